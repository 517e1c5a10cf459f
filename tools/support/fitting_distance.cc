#include "tools/support/fitting_distance.h"

#include <algorithm>
#include <cmath>

namespace vantage {

double FittingDistance(double radius, const CameraModel& camera, double nearest) {
  constexpr double kClearance = 0.05;    // m, kept from the sensor's nearest depth.
  constexpr double kImageMargin = 1.05;  // Of the ball, in the image.
  const double half_width = std::min(camera.cx, camera.width - 1 - camera.cx) / camera.fx;
  const double half_height = std::min(camera.cy, camera.height - 1 - camera.cy) / camera.fy;
  const double half_angle = std::atan(std::min(half_width, half_height));
  return std::max(nearest + kClearance + radius, kImageMargin * radius / std::sin(half_angle));
}

}  // namespace vantage
