#pragma once

#include <cmath>

namespace vantage {

/// w_v of the paper's equation 4: how correct a detection is, judged by the mean squared distance
/// (m^2) of the explained points to the aligned model; 1 at a perfect fit. Both arguments are
/// squared lengths: with the sensor's noise s in m, sigma = s^2.
/// @param sigma sigma_vw, m^2, > 0.
inline double VerificationWeight(double mse, double sigma) {
  return std::exp(-mse * mse / (2.0 * sigma * sigma));
}

}  // namespace vantage
