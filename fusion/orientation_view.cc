#include "fusion/orientation_view.h"

#include <cmath>

#include "common/format.h"

namespace vantage {
namespace {

Result<void> CheckNorm(const char* what, const Eigen::Vector4d& q) {
  constexpr double kNormTolerance = 1e-3;
  if (std::abs(q.norm() - 1.0) <= kNormTolerance) return {};  // False for NaN.
  return Error{ErrorCode::kInvalidArgument,
               Format("%s w, x, y, z = %g, %g, %g, %g has norm %g, expected 1",
                      what,
                      q[3],
                      q[0],
                      q[1],
                      q[2],
                      q.norm())};
}

}  // namespace

Result<void> OrientationView::Validate() const {
  if (auto valid = CheckNorm("orientation", q_world_object.coeffs()); !valid) return valid;
  if (q_world_camera) {
    auto valid = CheckNorm("orientation of the camera", q_world_camera->coeffs());
    if (!valid) return valid;
  }
  if (!(mse >= 0.0 && std::isfinite(mse))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("mse = %g m^2, expected finite and not negative", mse)};
  }
  return {};
}

}  // namespace vantage
