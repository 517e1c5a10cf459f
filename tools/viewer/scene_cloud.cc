#include "tools/viewer/scene_cloud.h"

#include <cmath>
#include <optional>
#include <unordered_set>

namespace vantage {
namespace {

constexpr double kFarthestVoxel = 1 << 20;  // From the origin, along an axis.

// A voxel's number; nothing too far from the origin, or for what is not finite.
std::optional<uint64_t> VoxelOf(const Eigen::Vector3f& point, double side) {
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = std::floor(static_cast<double>(point[axis]) / side) + kFarthestVoxel;
    if (!(place >= 0.0 && place < 2.0 * kFarthestVoxel)) return std::nullopt;
    key = (key << 21U) | static_cast<uint64_t>(place);
  }
  return key;
}

}  // namespace

void SceneCloud::Add(const DepthImage& depth,
                     const CameraModel& camera,
                     const Pose& T_world_camera,
                     const PixelColor& color) {
  if (depth.width != camera.width || depth.height != camera.height) return;
  std::unordered_set<uint64_t> taken;
  taken.reserve(2 * parameters_.max_points);
  for (const auto& chunk : chunks_) {
    for (const CloudPoint& point : chunk->points) {
      if (const auto voxel = VoxelOf(point.position, parameters_.voxel)) taken.insert(*voxel);
    }
  }
  auto added = std::make_shared<CloudChunk>();
  added->has_color = static_cast<bool>(color);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const double z = static_cast<double>(depth.at(u, v));
      if (!(z > 0.0 && z <= parameters_.max_depth)) continue;
      if (added->points.size() >= parameters_.max_points) break;
      CloudPoint point;
      point.position = (T_world_camera * camera.Unproject(u, v, z)).cast<float>();
      const std::optional<uint64_t> voxel = VoxelOf(point.position, parameters_.voxel);
      if (!voxel || !taken.insert(*voxel).second) continue;
      point.depth = static_cast<float>(z);
      if (color) point.color = color(u, v);
      added->points.push_back(point);
    }
  }
  if (added->points.empty()) return;
  chunks_.push_back(std::move(added));
  while (num_points() > parameters_.max_points) chunks_.erase(chunks_.begin());
}

size_t SceneCloud::num_points() const {
  size_t count = 0;
  for (const auto& chunk : chunks_) count += chunk->points.size();
  return count;
}

}  // namespace vantage
