#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/triangle_mesh.h"
#include "perception/segmentation/cluster.h"
#include "perception/segmentation/cube_grid.h"
#include "perception/segmentation/normals.h"

namespace vantage {

/// Surface points with normals of one segment, evenly spread. Owns its buffers: allocates nothing
/// once warm.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(const NormalParameters& parameters) : parameters_(parameters) {}

  /// The surface at about one pixel of every cube of `spacing` m that holds some of the cluster:
  /// the one nearest to the mean of those in the cube. In the order of the cubes' first pixels.
  /// Valid until the next call.
  ///
  /// The surface at a pixel is a plane fitted to inverse depth, which is affine in the image on a
  /// plane and in which the steps of a structured-light camera have one size. Neighbors of another
  /// label or across a depth discontinuity are left out; then those that disagree with the plane,
  /// which keeps the near side of creases. The position lies on the line of sight of the pixel.
  /// There is no point where too few neighbors are left.
  /// @param labels of all pixels of the image (Segmentation::labels).
  std::span<const SurfacePoint> Sample(const DepthImage& depth,
                                       const CameraModel& camera,
                                       std::span<const int32_t> labels,
                                       const Cluster& cluster,
                                       double spacing);

  /// Of the points one in every cube of `spacing` m, chosen likewise. Valid until the next call;
  /// `points` may be those of Sample().
  std::span<const SurfacePoint> Thin(std::span<const SurfacePoint> points, double spacing);

 private:
  void CopyWindow(const DepthImage& depth,
                  std::span<const int32_t> labels,
                  const PixelWindow& inner);
  [[nodiscard]] size_t Place(int u, int v) const {
    return static_cast<size_t>(v - window_.v0) * stride_ + static_cast<size_t>(u - window_.u0);
  }
  void ChoosePixels(const DepthImage& depth,
                    const CameraModel& camera,
                    const Cluster& cluster,
                    double spacing);
  void AddSurfaceAt(const CameraModel& camera, uint32_t pixel, int width);

  NormalParameters parameters_;
  // The cluster's window with a margin: 1 / z, NaN outside of the image, and labels.
  PixelWindow window_;
  size_t stride_ = 0;
  std::vector<float> rho_;
  std::vector<int32_t> labels_;
  CubeGrid cubes_;
  std::vector<uint32_t> pixels_;
  std::vector<SurfacePoint> samples_;
  std::vector<SurfacePoint> thinned_;
};

}  // namespace vantage
