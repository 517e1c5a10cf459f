#include "drivers/sim/sensor_parameters.h"

#include "common/format.h"

namespace vantage {

void SensorModelParameters::SwitchAllOff() {
  quantization = false;
  axial_noise = false;
  lateral_noise = false;
  shadow = false;
  grazing_dropout = false;
  bias = false;
}

Result<void> SensorModelParameters::Validate() const {
  struct Bound {
    const char* name;
    double value, lowest, highest;
  };
  const Bound bounds[] = {
      {"baseline", baseline, 0.001, 1.0},
      {"nearest", nearest, 0.1, 100.0},
      {"farthest", farthest, nearest, 100.0},
      {"disparity_step", disparity_step, 1e-4, 10.0},
      {"axial_sigma", axial_sigma, 0.0, 10.0},
      {"grazing_sigma", grazing_sigma, 0.0, 0.1},
      {"correlation", correlation, 0.0, 20.0},
      {"lateral_sigma", lateral_sigma, 0.0, 4.0},
      {"lateral_sigma_angle", lateral_sigma_angle, 0.0, 1.0},
      {"edge_step", edge_step, 0.01, 100.0},
      {"dropout_start", dropout_start, 0.0, 90.0 * kDegree},
      {"dropout_end", dropout_end, dropout_start + 0.1 * kDegree, 90.1 * kDegree},
      {"bias_at_1m", bias_at_1m, 0.0, 0.1},
      {"bias_period", bias_period, 1.0, 1e6},
  };
  for (const Bound& bound : bounds) {
    if (!(bound.value >= bound.lowest && bound.value <= bound.highest)) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("sensor model: %s = %g, expected %g to %g",
                          bound.name,
                          bound.value,
                          bound.lowest,
                          bound.highest)};
    }
  }
  return {};
}

uint64_t DeviceIdFromSerial(const std::string& serial) {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : serial) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  }
  return hash;
}

}  // namespace vantage
