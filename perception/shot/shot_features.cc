#include "perception/shot/shot_features.h"

#include <pcl/features/shot.h>
#include <pcl/features/shot_lrf.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>

namespace vantage {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using Frames = pcl::PointCloud<pcl::ReferenceFrame>;

// Turns a frame about its x so that z is on the normal's side.
void TurnTowards(const Eigen::Vector3f& normal, pcl::ReferenceFrame* frame) {
  const Eigen::Map<const Eigen::Vector3f> z(frame->z_axis);
  if (!(z.dot(normal) < 0.0F)) return;
  for (int i = 0; i < 3; ++i) {
    frame->y_axis[i] = -frame->y_axis[i];
    frame->z_axis[i] = -frame->z_axis[i];
  }
}

}  // namespace

struct ShotFeatures::Clouds {
  Cloud::Ptr surface = std::make_shared<Cloud>();
  pcl::PointCloud<pcl::Normal>::Ptr normals = std::make_shared<pcl::PointCloud<pcl::Normal>>();
  Cloud::Ptr keypoints = std::make_shared<Cloud>();
  Frames::Ptr frames = std::make_shared<Frames>();
  std::vector<uint32_t> described;  // Keypoints that have a frame.
  pcl::PointCloud<pcl::SHOT352> descriptors;
};

ShotFeatures::ShotFeatures() : clouds_(std::make_unique<Clouds>()) {}
ShotFeatures::~ShotFeatures() = default;
ShotFeatures::ShotFeatures(ShotFeatures&&) noexcept = default;
ShotFeatures& ShotFeatures::operator=(ShotFeatures&&) noexcept = default;

std::span<const ShotFeature> ShotFeatures::Compute(std::span<const SurfacePoint> points,
                                                   std::span<const uint32_t> keypoints,
                                                   double radius) {
  features_.clear();
  if (points.empty() || keypoints.empty()) return features_;
  Clouds& clouds = *clouds_;
  clouds.surface->clear();
  clouds.normals->clear();
  clouds.keypoints->clear();
  for (const SurfacePoint& point : points) {
    const Eigen::Vector3f& p = point.position;
    clouds.surface->emplace_back(p.x(), p.y(), p.z());
    clouds.normals->emplace_back(point.normal.x(), point.normal.y(), point.normal.z());
  }
  for (const uint32_t index : keypoints) clouds.keypoints->push_back((*clouds.surface)[index]);
  const auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();

  pcl::SHOTLocalReferenceFrameEstimation<pcl::PointXYZ, pcl::ReferenceFrame> framing;
  framing.setInputCloud(clouds.keypoints);
  framing.setSearchSurface(clouds.surface);
  framing.setSearchMethod(tree);
  framing.setRadiusSearch(radius);
  framing.compute(*clouds.frames);
  // PCL reports every keypoint without a frame on the terminal, so those are left out before.
  clouds.described.clear();
  for (size_t i = 0; i < keypoints.size(); ++i) {
    pcl::ReferenceFrame frame = (*clouds.frames)[i];
    if (!std::isfinite(frame.x_axis[0])) continue;
    TurnTowards(points[keypoints[i]].normal, &frame);
    const size_t place = clouds.described.size();
    (*clouds.frames)[place] = frame;
    (*clouds.keypoints)[place] = (*clouds.keypoints)[i];
    clouds.described.push_back(keypoints[i]);
  }
  clouds.frames->resize(clouds.described.size());
  clouds.keypoints->resize(clouds.described.size());
  if (clouds.described.empty()) return features_;

  tree->setSortedResults(false);
  pcl::SHOTEstimation<pcl::PointXYZ, pcl::Normal, pcl::SHOT352> describing;
  describing.setInputCloud(clouds.keypoints);
  describing.setSearchSurface(clouds.surface);
  describing.setInputNormals(clouds.normals);
  describing.setInputReferenceFrames(clouds.frames);
  describing.setSearchMethod(tree);
  describing.setRadiusSearch(radius);
  describing.compute(clouds.descriptors);

  for (size_t i = 0; i < clouds.described.size(); ++i) {
    const float* values = clouds.descriptors[i].descriptor;
    if (!std::all_of(values, values + kShotSize, [](float v) { return std::isfinite(v); }))
      continue;
    ShotFeature& feature = features_.emplace_back();
    feature.point = points[clouds.described[i]];
    std::copy_n(values, kShotSize, feature.descriptor.begin());
  }
  return features_;
}

}  // namespace vantage
