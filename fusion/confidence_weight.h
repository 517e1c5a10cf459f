#pragma once

#include <cmath>

namespace vantage {

/// w_c of the paper's equation 2: how far an orientation at `angle` d_q (rad) from a detected one
/// is supported by it; 1 at the detection.
/// @param sigma sigma_cw, rad, > 0.
inline double ConfidenceWeight(double angle, double sigma) {
  return std::exp(-angle * angle / (2.0 * sigma * sigma));
}

/// Beyond this many sigma_cw the Gaussian is cut off (paper 5.1: "a truncated Gaussian").
inline constexpr double kConfidenceCutoff = 3.0;

}  // namespace vantage
