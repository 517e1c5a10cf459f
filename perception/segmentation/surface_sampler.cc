#include "perception/segmentation/surface_sampler.h"

#include <cmath>
#include <unordered_set>

namespace vantage {

std::span<const SurfacePoint> SurfaceSampler::Sample(const DepthImage& depth,
                                                     const CameraModel& camera,
                                                     std::span<const int32_t> labels,
                                                     const Cluster& cluster,
                                                     double spacing) {
  samples_ = SampleSurfaces(depth, camera, labels, cluster.pixels, spacing, parameters_);
  return samples_;
}

std::span<const SurfacePoint> SurfaceSampler::Thin(std::span<const SurfacePoint> points,
                                                   double spacing) {
  std::unordered_set<uint64_t> taken;
  thinned_.clear();
  for (const SurfacePoint& point : points) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::floor(static_cast<double>(point.position(axis)) / spacing);
      key = (key << 21U) |
            (static_cast<uint64_t>(static_cast<int64_t>(cell) + (1 << 20)) & 0x1fffffU);
    }
    if (taken.insert(key).second) thinned_.push_back(point);
  }
  return thinned_;
}

}  // namespace vantage
