#include "perception/refinement/refinement_parameters.h"

#include "common/format.h"

namespace vantage {

Result<void> RefinementParameters::Validate() const {
  constexpr int kMost = 1000;
  constexpr int kMostPoints = 1000000;
  if (coarse_iterations < 0 || coarse_iterations > kMost || fine_iterations < 0 ||
      fine_iterations > kMost || final_iterations < 0 || final_iterations > kMost) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("refinement: %d coarse, %d fine and %d final iterations, expected 0 to 1000",
               coarse_iterations,
               fine_iterations,
               final_iterations)};
  }
  if (!(coarse_reach > 0.0 && coarse_reach_end > 0.0 && coarse_reach_end <= coarse_reach &&
        fine_reach > 0.0 && coarse_reach <= 1.0 && tukey_sigmas > 0.0 && model_error >= 0.0 &&
        converged >= 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("refinement: reaches %g to %g and %g of the diameter (expected 0 to 1, "
                        "descending), tukey_sigmas = %g (expected above 0), model_error = %g m and "
                        "converged = %g (expected 0 or more)",
                        coarse_reach,
                        coarse_reach_end,
                        fine_reach,
                        tukey_sigmas,
                        model_error,
                        converged)};
  }
  if (fine_points < 1 || fine_points > kMostPoints || final_points < 1 ||
      final_points > kMostPoints || !(correlated_px > 0.0) || !(bias_at_1m >= 0.0) ||
      !(bias_tilt >= 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("refinement: %d fine and %d final points (expected 1 to 1000000), "
                        "correlated_px = %g (expected above 0), bias_at_1m = %g m and bias_tilt = "
                        "%g rad (expected 0 or more)",
                        fine_points,
                        final_points,
                        correlated_px,
                        bias_at_1m,
                        bias_tilt)};
  }
  return {};
}

}  // namespace vantage
