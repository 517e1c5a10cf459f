#include "tests/bench/pose_comparison/pcl_clouds.h"

#include <pcl/console/print.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_point_to_plane_lls.h>
#include <pcl/search/kdtree.h>

#include "perception/model/surface_samples.h"

namespace vantage {
namespace {

PclPoints::Ptr Downsample(const PclPoints::Ptr& cloud, double leaf) {
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(cloud);
  const auto size = static_cast<float>(leaf);
  grid.setLeafSize(size, size, size);
  const PclPoints::Ptr out(new PclPoints);
  grid.filter(*out);
  return out;
}

// Where the equations have no solution the library returns NaN, at which its search then ends the
// program: the points stay where they are instead.
class FinitePointToPlane
    : public pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal,
                                                                        pcl::PointNormal> {
 public:
  using Base = pcl::registration::TransformationEstimationPointToPlaneLLS<pcl::PointNormal,
                                                                          pcl::PointNormal>;
  using Base::estimateRigidTransformation;
  void estimateRigidTransformation(const PclSurface& source,
                                   const PclSurface& target,
                                   const pcl::Correspondences& correspondences,
                                   Matrix4& motion) const override {
    Base::estimateRigidTransformation(source, target, correspondences, motion);
    if (!motion.allFinite()) motion.setIdentity();
  }
};

}  // namespace

void SilencePcl() { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }

PclSurface::Ptr ModelSurface(const ObjectModel& model, double spacing) {
  SurfaceSampleParameters parameters;
  parameters.spacing = spacing;
  Rng rng(1);
  const PclSurface::Ptr cloud(new PclSurface);
  for (const SurfacePoint& sample :
       SampleVisibleSurface(model.mesh, model.diameter, parameters, rng)) {
    pcl::PointNormal point;
    point.getVector3fMap() = sample.position;
    point.getNormalVector3fMap() = sample.normal;
    cloud->push_back(point);
  }
  return cloud;
}

PclSurface::Ptr SceneSurface(std::span<const Eigen::Vector3f> points,
                             double leaf,
                             double normal_leaf,
                             double normal_radius) {
  const PclPoints::Ptr all(new PclPoints);
  all->reserve(points.size());
  for (const Eigen::Vector3f& p : points) all->push_back(pcl::PointXYZ(p.x(), p.y(), p.z()));
  const PclPoints::Ptr fine = Downsample(all, normal_leaf);
  const PclPoints::Ptr coarse = leaf > normal_leaf ? Downsample(all, leaf) : fine;
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(coarse);
  estimation.setSearchSurface(fine);
  const pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
  estimation.setSearchMethod(tree);
  estimation.setRadiusSearch(normal_radius);
  estimation.setViewPoint(0.0F, 0.0F, 0.0F);
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  const PclSurface::Ptr surface(new PclSurface);
  for (size_t i = 0; i < coarse->size(); ++i) {
    if (!normals[i].getNormalVector3fMap().allFinite()) continue;  // Too few neighbors.
    pcl::PointNormal point;
    point.getVector3fMap() = (*coarse)[i].getVector3fMap();
    point.getNormalVector3fMap() = normals[i].getNormalVector3fMap();
    point.curvature = normals[i].curvature;
    surface->push_back(point);
  }
  return surface;
}

Pose RefineWithIcp(const PclSurface::Ptr& scene,
                   const PclSurface::Ptr& model,
                   const Pose& T_camera_object,
                   double diameter) {
  constexpr double kReach = 0.1;  // Of the diameter; farther points have no correspondence.
  constexpr int kIterations = 50;
  constexpr double kTransformationEpsilon = 1e-8;
  pcl::IterativeClosestPointWithNormals<pcl::PointNormal, pcl::PointNormal> icp;
  icp.setTransformationEstimation(pcl::make_shared<FinitePointToPlane>());
  icp.setInputSource(scene);
  icp.setInputTarget(model);
  icp.setMaxCorrespondenceDistance(kReach * diameter);
  icp.setMaximumIterations(kIterations);
  icp.setTransformationEpsilon(kTransformationEpsilon);
  PclSurface aligned;
  icp.align(aligned, T_camera_object.inverse().matrix().cast<float>());
  if (!icp.hasConverged()) return T_camera_object;
  const Eigen::Matrix4d T_object_camera = icp.getFinalTransformation().cast<double>();
  return Pose(T_object_camera).inverse();
}

}  // namespace vantage
