#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/camera_intrinsics.h"
#include "common/so3.h"

namespace vantage {

/// Where the pixels of a depth image lie for another camera. A pixel's ray r, undistorted, and its
/// depth z make the point z R r + t of that camera's frame; what does not depend on z is kept.
class RayProjection {
 public:
  /// Depth of what has no measurement, lies behind the camera or has no ray, mm.
  static constexpr float kFar = 1e9F;
  static constexpr float kNear = 10.0F;  ///< mm, from the other camera

  /// @param depth of the image as it will be given
  /// @param target an ideal camera
  RayProjection(const CameraIntrinsics& depth,
                const CameraModel& target,
                const Pose& T_target_depth);

  [[nodiscard]] int width() const { return width_; }    ///< px, of the depth image
  [[nodiscard]] int height() const { return height_; }  ///< px, alike

  /// Values of a padded row: width() rounded up to whole vectors.
  [[nodiscard]] size_t stride() const { return stride_; }
  /// One row of the depth image, mm, 0: no measurement, to pixel coordinates in the target's image
  /// and depth along its axis, mm. Each of the three has stride() values; a pixel of depth kFar has
  /// no place, as those beyond width().
  void ProjectRow(int row, const uint16_t* depth_mm, float* u, float* v, float* z) const;

 private:
  int width_;
  int height_;
  size_t stride_;
  Eigen::Vector3f offset_;  // K t, mm
  std::vector<float> u_;    // K R r, three values a pixel, in padded rows
  std::vector<float> v_;
  std::vector<float> w_;
};

}  // namespace vantage
