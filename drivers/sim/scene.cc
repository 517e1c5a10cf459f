#include "drivers/sim/scene.h"

#include <cmath>

#include "common/format.h"

namespace vantage {

Result<void> SimPlane::Validate() const {
  constexpr double kFarthest = 100.0;
  for (const double side : {size.x(), size.y()}) {
    if (!(side >= 0.01 && side <= kFarthest)) {
      return Error{
          ErrorCode::kInvalidArgument,
          Format("plane of %g x %g m, expected 0.01 to %g m", size.x(), size.y(), kFarthest)};
    }
  }
  for (const double value : {height, center.x(), center.y()}) {
    if (!(std::abs(value) <= kFarthest)) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("plane at (%g, %g, %g) m, expected within %g m of the origin",
                          center.x(),
                          center.y(),
                          height,
                          kFarthest)};
    }
  }
  return {};
}

}  // namespace vantage
