#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace vantage {

/// By what the points of the cloud are colored.
enum class CloudColor {
  kDepth,   ///< distance from the camera that saw them
  kHeight,  ///< along the world's z axis
  kImage,   ///< color images; height where there was none
};

/// What of the state is shown, and how.
struct ViewerOptions {
  /// Unit, in the object's frame: where orientations take it is the point of the sphere.
  Eigen::Vector3d vector = Eigen::Vector3d::Ones().normalized();
  std::optional<int32_t> object;  ///< instance whose orientation is shown; the first without
  CloudColor cloud_color = CloudColor::kImage;
  bool show_cloud = true;
  bool show_candidates = true;
  bool show_uncertainty = true;
  double ellipsoid_sigmas = 30.0;  ///< semi-axes in standard deviations: those alone are too small
  double cone_sigmas = 10.0;       ///< half width of the cones about the axes
  double table_height = 0.0;       ///< m, world
};

}  // namespace vantage
