#include "drivers/sim/sensor_text.h"

// Parameters are taken apart by structured bindings: a new one does not compile until it is listed.

namespace vantage {

void AddCamera(const CameraModel& camera, ParameterText* text) {
  const auto& [width, height, fx, fy, cx, cy] = camera;
  text->Line("camera", width, height, fx, fy, cx, cy);
}

void AddSensor(const SensorModelParameters& parameters, ParameterText* text) {
  const auto& [seed,
               device_id,
               baseline,
               nearest,
               farthest,
               quantization,
               disparity_step,
               axial_noise,
               axial_sigma,
               grazing_sigma,
               correlation,
               lateral_noise,
               lateral_sigma,
               lateral_sigma_angle,
               edge_step,
               shadow,
               grazing_dropout,
               dropout_start,
               dropout_end,
               bias,
               bias_at_1m,
               bias_period] = parameters;
  static_cast<void>(seed);  // Whoever simulates chooses both.
  static_cast<void>(device_id);
  text->Line("sensor", baseline, nearest, farthest, quantization, disparity_step);
  text->Line("noise", axial_noise, axial_sigma, grazing_sigma, correlation);
  text->Line("edges", lateral_noise, lateral_sigma, lateral_sigma_angle, edge_step, shadow);
  text->Line("dropout", grazing_dropout, dropout_start, dropout_end);
  text->Line("bias", bias, bias_at_1m, bias_period);
}

}  // namespace vantage
