#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "tools/support/color.h"
#include "tools/support/png_image.h"

namespace vantage {

/// Weight at a point of the unit sphere.
struct SphereSample {
  Eigen::Vector3f direction;  ///< unit
  float weight = 0.0F;
};

struct SphereView {
  int radius_px = 110;
  Eigen::Vector3d towards = {1.0, 1.0, 1.0};  ///< The point of the sphere nearest to the viewer.
  double kernel = 0.035;                      ///< rad, standard deviation of the smoothing
  Rgb background = {255, 255, 255};
};

/// The density of samples on the unit sphere in color, seen from `towards` (left half of the
/// picture) and from the opposite side (right half), with a graticule of 30 degrees about the z
/// axis and colored ends of the x, y and z axes (red, green, blue; hollow at the negative ends).
/// Colors go from none to the highest density of this picture. The picture is 4 r + 3 m wide and 2
/// r + 2 m high, m = 8 px.
RgbImage RenderSphereDensity(std::span<const SphereSample> samples, const SphereView& view);

/// R_view_world of a look at the sphere: `towards`, not zero, points at the viewer (z), the world's
/// z axis is up (y); where they are parallel, the world's x axis is to the right (x).
Eigen::Matrix3d ViewRotation(const Eigen::Vector3d& towards);

/// Paper section 4.1: where orientations take v1 = (1, 1, 1) / sqrt(3).
Eigen::Vector3d DirectionOfOrientation(const Eigen::Quaterniond& orientation);

}  // namespace vantage
