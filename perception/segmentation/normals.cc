#include "perception/segmentation/normals.h"

#include <algorithm>

#include "common/format.h"
#include "perception/segmentation/surface_sampler.h"

namespace vantage {
Result<void> NormalParameters::Validate() const {
  if (!(radius > 0.0 && radius < 1.0) || min_radius_px < 1 || max_radius_px < min_radius_px ||
      max_radius_px > 100 || !(min_share >= 0.0 && min_share <= 1.0)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("normals: radius = %g m (expected 0 to 1), %d to %d px (expected 1 to 100), "
               "min_share = %g (expected 0 to 1)",
               radius,
               min_radius_px,
               max_radius_px,
               min_share)};
  }
  return {};
}

std::vector<SurfacePoint> SampleSurfaces(const DepthImage& depth,
                                         const CameraModel& camera,
                                         std::span<const int32_t> labels,
                                         std::span<const uint32_t> pixels,
                                         double spacing,
                                         const NormalParameters& parameters) {
  Cluster cluster;
  cluster.pixels.assign(pixels.begin(), pixels.end());
  if (pixels.empty()) return {};
  cluster.window = {depth.width, depth.height, -1, -1};
  for (const uint32_t pixel : pixels) {
    const int u = static_cast<int>(pixel) % depth.width;
    const int v = static_cast<int>(pixel) / depth.width;
    cluster.window = {std::min(cluster.window.u0, u),
                      std::min(cluster.window.v0, v),
                      std::max(cluster.window.u1, u),
                      std::max(cluster.window.v1, v)};
  }
  SurfaceSampler sampler(parameters);
  const std::span<const SurfacePoint> samples =
      sampler.Sample(depth, camera, labels, cluster, spacing);
  return {samples.begin(), samples.end()};
}

}  // namespace vantage
