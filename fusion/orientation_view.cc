#include "fusion/orientation_view.h"

#include <cmath>

#include "common/format.h"

namespace vantage {

Result<void> OrientationView::Validate() const {
  const Eigen::Vector4d q = q_world_object.coeffs();
  constexpr double kNormTolerance = 1e-3;
  if (!(std::abs(q.norm() - 1.0) <= kNormTolerance)) {  // False for NaN too.
    return Error{ErrorCode::kInvalidArgument,
                 Format("orientation w, x, y, z = %g, %g, %g, %g has norm %g, expected 1",
                        q[3],
                        q[0],
                        q[1],
                        q[2],
                        q.norm())};
  }
  if (!(mse >= 0.0 && std::isfinite(mse))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("mse = %g m^2, expected finite and not negative", mse)};
  }
  return {};
}

}  // namespace vantage
