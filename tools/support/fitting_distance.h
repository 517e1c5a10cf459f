#pragma once

#include "common/camera_model.h"

namespace vantage {

/// Distance from which a ball on the optical axis is wholly in a camera's image, with some margin,
/// and beyond the sensor's nearest depth, m.
/// @param radius m, of the ball. @param nearest m, of the sensor.
double FittingDistance(double radius, const CameraModel& camera, double nearest);

}  // namespace vantage
