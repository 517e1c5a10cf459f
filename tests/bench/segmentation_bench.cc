// Segments of a VGA frame of three objects on a table, beside the two chains of the Point Cloud
// Library that do the same: on voxels, and on the organized image. Counters tell the segments.
#include <benchmark/benchmark.h>
#include <pcl/features/integral_image_normal.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/filters/passthrough.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/euclidean_cluster_comparator.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/organized_connected_component_segmentation.h>
#include <pcl/segmentation/organized_multi_plane_segmentation.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>
#include <set>

#include "perception/segmentation/segmentation.h"
#include "perception/segmentation/surface_sampler.h"
#include "tests/bench/table_frames.h"

namespace vantage {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr float kDepthRange[] = {0.2F, 3.0F};  // m
constexpr double kPlaneTolerance = 0.012;      // m, 3 sigmas of the floor
constexpr double kGap = 0.012;                 // m

const TableFrame& Frame() {
  static const TableFrame frame = MakeTableFrame(1);
  return frame;
}

Cloud::Ptr ToCloud(const TableFrame& frame) {
  auto cloud = std::make_shared<Cloud>(frame.camera.width, frame.camera.height);
  cloud->is_dense = false;
  for (int v = 0; v < frame.camera.height; ++v) {
    for (int u = 0; u < frame.camera.width; ++u) {
      const auto z = static_cast<double>(frame.depth.at(u, v));
      const Eigen::Vector3f point = frame.camera.Unproject(u, v, z).cast<float>();
      (*cloud)(static_cast<size_t>(u), static_cast<size_t>(v)) = {point.x(), point.y(), point.z()};
    }
  }
  return cloud;
}

void BM_Segmenter(benchmark::State& state) {
  Segmenter segmenter({});
  const Segmentation* result = nullptr;
  for (auto _ : state) {
    Rng rng(1);
    result = &segmenter.Segment(Frame().depth, Frame().camera, rng);
  }
  const auto whole = std::count_if(result->clusters.begin(),
                                   result->clusters.end(),
                                   [](const Cluster& cluster) { return cluster.parent < 0; });
  state.counters["clusters"] = static_cast<double>(whole);
  state.counters["parts"] =
      static_cast<double>(result->clusters.size()) - static_cast<double>(whole);
}
BENCHMARK(BM_Segmenter)->Unit(benchmark::kMillisecond);

void BM_SurfacePointsOfLargestCluster(benchmark::State& state) {
  Rng rng(1);
  const Segmentation segmentation = Segment(Frame().depth, Frame().camera, {}, rng);
  SurfaceSampler sampler({});
  size_t points = 0;
  for (auto _ : state) {
    points =
        sampler
            .Sample(
                Frame().depth, Frame().camera, segmentation.labels, segmentation.clusters[0], 0.006)
            .size();
  }
  state.counters["points"] = static_cast<double>(points);
  state.counters["pixels"] = static_cast<double>(segmentation.clusters[0].pixels.size());
}
BENCHMARK(BM_SurfacePointsOfLargestCluster)->Unit(benchmark::kMillisecond);

// Pass-through, voxels of 5 mm, planes by RANSAC, Euclidean clusters. The cloud is made before.
void BM_PclVoxelsPlanesEuclideanClusters(benchmark::State& state) {
  const Cloud::Ptr cloud = ToCloud(Frame());
  std::vector<pcl::PointIndices> clusters;
  for (auto _ : state) {
    auto points = std::make_shared<Cloud>();
    pcl::PassThrough<pcl::PointXYZ> pass;
    pass.setInputCloud(cloud);
    pass.setFilterFieldName("z");
    pass.setFilterLimits(kDepthRange[0], kDepthRange[1]);
    pass.filter(*points);
    pcl::VoxelGrid<pcl::PointXYZ> voxels;
    voxels.setInputCloud(points);
    voxels.setLeafSize(0.005F, 0.005F, 0.005F);
    auto thinned = std::make_shared<Cloud>();
    voxels.filter(*thinned);
    for (int plane = 0; plane < 2; ++plane) {  // The table and the floor.
      pcl::SACSegmentation<pcl::PointXYZ> search;
      search.setModelType(pcl::SACMODEL_PLANE);
      search.setMethodType(pcl::SAC_RANSAC);
      search.setDistanceThreshold(kPlaneTolerance);
      search.setMaxIterations(300);
      search.setInputCloud(thinned);
      auto inliers = std::make_shared<pcl::PointIndices>();
      pcl::ModelCoefficients coefficients;
      search.segment(*inliers, coefficients);
      pcl::ExtractIndices<pcl::PointXYZ> extract;
      extract.setInputCloud(thinned);
      extract.setIndices(inliers);
      extract.setNegative(true);
      auto rest = std::make_shared<Cloud>();
      extract.filter(*rest);
      thinned = rest;
    }
    auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
    tree->setInputCloud(thinned);
    pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
    extraction.setClusterTolerance(kGap);
    extraction.setMinClusterSize(30);
    extraction.setSearchMethod(tree);
    extraction.setInputCloud(thinned);
    clusters.clear();
    extraction.extract(clusters);
  }
  state.counters["clusters"] = static_cast<double>(clusters.size());
}
BENCHMARK(BM_PclVoxelsPlanesEuclideanClusters)->Unit(benchmark::kMillisecond);

// Normals by integral images, planes of the organized image, connected components off them.
void BM_PclOrganizedPlanesAndComponents(benchmark::State& state) {
  const Cloud::Ptr cloud = ToCloud(Frame());
  size_t count = 0;
  for (auto _ : state) {
    auto normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
    pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
    estimation.setNormalEstimationMethod(estimation.COVARIANCE_MATRIX);
    estimation.setMaxDepthChangeFactor(0.02F);
    estimation.setNormalSmoothingSize(10.0F);
    estimation.setInputCloud(cloud);
    estimation.compute(*normals);
    pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> planes;
    planes.setMinInliers(10000);
    planes.setAngularThreshold(0.05);
    planes.setDistanceThreshold(0.02);
    planes.setInputNormals(normals);
    planes.setInputCloud(cloud);
    std::vector<pcl::PlanarRegion<pcl::PointXYZ>,
                Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>>
        regions;
    std::vector<pcl::ModelCoefficients> coefficients;
    std::vector<pcl::PointIndices> inliers;
    auto labels = std::make_shared<pcl::PointCloud<pcl::Label>>();
    std::vector<pcl::PointIndices> label_indices;
    std::vector<pcl::PointIndices> boundary;
    planes.segmentAndRefine(regions, coefficients, inliers, labels, label_indices, boundary);
    auto excluded = std::make_shared<std::set<uint32_t>>();
    for (size_t i = 0; i < label_indices.size(); ++i) {
      if (label_indices[i].indices.size() > 10000) excluded->insert(static_cast<uint32_t>(i));
    }
    using Comparator = pcl::EuclideanClusterComparator<pcl::PointXYZ, pcl::Label>;
    auto comparator = std::make_shared<Comparator>();
    comparator->setInputCloud(cloud);
    comparator->setLabels(labels);
    comparator->setExcludeLabels(excluded);
    comparator->setDistanceThreshold(static_cast<float>(kGap), false);
    pcl::OrganizedConnectedComponentSegmentation<pcl::PointXYZ, pcl::Label> components(comparator);
    components.setInputCloud(cloud);
    pcl::PointCloud<pcl::Label> component_labels;
    std::vector<pcl::PointIndices> found;
    components.segment(component_labels, found);
    count = static_cast<size_t>(
        std::count_if(found.begin(), found.end(), [](const pcl::PointIndices& component) {
          return component.indices.size() >= 200;
        }));
  }
  state.counters["clusters"] = static_cast<double>(count);
}
BENCHMARK(BM_PclOrganizedPlanesAndComponents)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vantage
