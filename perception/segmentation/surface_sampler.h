#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/triangle_mesh.h"
#include "perception/segmentation/normals.h"
#include "perception/segmentation/segmentation.h"

namespace vantage {

/// Surface points with normals of one segment, evenly spread. Owns its buffers: allocates nothing
/// once warm.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(const NormalParameters& parameters) : parameters_(parameters) {}

  /// SurfaceAt about one pixel of every cube of `spacing` m that holds some of the cluster: the one
  /// nearest to the mean of those in the cube. In the order of the cubes' first pixels. Valid until
  /// the next call.
  std::span<const SurfacePoint> Sample(const DepthImage& depth,
                                       const CameraModel& camera,
                                       std::span<const int32_t> labels,
                                       const Cluster& cluster,
                                       double spacing);

  /// Of the points about one in every cube of `spacing` m, chosen likewise. Valid until the next
  /// call; `points` may be those of Sample().
  std::span<const SurfacePoint> Thin(std::span<const SurfacePoint> points, double spacing);

 private:
  NormalParameters parameters_;
  std::vector<SurfacePoint> samples_;
  std::vector<SurfacePoint> thinned_;
};

}  // namespace vantage
