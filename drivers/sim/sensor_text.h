#pragma once

#include "common/camera_model.h"
#include "common/parameter_text.h"
#include "drivers/sim/sensor_parameters.h"

namespace vantage {

/// Adds a line of the camera's parameters.
void AddCamera(const CameraModel& camera, ParameterText* text);

/// Adds lines of all parameters but the seed and the device.
void AddSensor(const SensorModelParameters& parameters, ParameterText* text);

}  // namespace vantage
