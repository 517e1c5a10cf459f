#include "drivers/v4l2/disparity_model.h"

#include <cmath>

#include "common/format.h"

namespace vantage {

Result<void> DisparityModel::Validate() const {
  const struct {
    const char* name;
    double value;
    double lowest;
    double highest;
  } ranges[] = {{"baseline_mm", baseline_mm, 1.0, 1000.0},
                {"focal_px", focal_px, 1.0, 1e5},
                {"offset", offset, 1.0, 1e5},
                {"steps_per_px", steps_per_px, 1.0, 64.0}};
  for (const auto& range : ranges) {
    if (range.value >= range.lowest && range.value <= range.highest) continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("disparity %s = %g, expected a number from %g to %g",
                        range.name,
                        range.value,
                        range.lowest,
                        range.highest)};
  }
  return {};
}

uint16_t DisparityModel::DepthMm(int d) const {
  const double steps = offset - d;
  if (!(steps > 0.0)) return 0;
  const double depth_mm = std::round(baseline_mm * focal_px * steps_per_px / steps);
  return depth_mm <= 65535.0 ? static_cast<uint16_t>(depth_mm) : uint16_t{0};
}

std::array<uint16_t, 1024> DisparityTable(const DisparityModel& model) {
  std::array<uint16_t, 1024> table{};
  for (int d = 0; d < 1023; ++d) table[static_cast<size_t>(d)] = model.DepthMm(d);
  return table;
}

}  // namespace vantage
