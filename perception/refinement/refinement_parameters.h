#pragma once

#include "common/result.h"
#include "perception/depth_noise.h"

namespace vantage {

struct RefinementParameters {
  int coarse_iterations = 8;       ///< on scene points, at most
  double coarse_reach = 0.15;      ///< of the diameter; pairs farther apart are cut at the start
  double coarse_reach_end = 0.06;  ///< of the diameter; at the end
  int fine_iterations = 5;         ///< on about `fine_points` pixels, at most
  int fine_points = 900;           ///< of a model drawn once
  double fine_reach = 0.06;        ///< of the diameter, at the start
  int final_iterations = 5;        ///< on about `final_points` pixels, at most
  int final_points = 6000;         ///< of a model drawn once
  double tukey_sigmas = 4.0;       ///< cut of the biweight (Tukey 1974: 4.685 for 95 % efficiency)
  double model_error = 0.0005;     ///< m, standard deviation that the sensor's noise adds to
  double converged = 1e-5;         ///< rad and m / 10; smaller steps end the iteration
  /// px that tell as much as one of independent noise `noise`. Smooth noise of a Gaussian window of
  /// 1.5 px has 4 pi 1.5^2 = 28 px to one, but its standard deviation is about half of `noise`;
  /// calibrated on simulated views.
  double correlated_px = 3.5;
  double bias_at_1m = 0.0003;  ///< m, standard deviation of a device's bias, growing with depth^2
  double bias_tilt = 0.001;    ///< rad, standard deviation of the slope that it adds
  DepthNoise noise;
  Result<void> Validate() const;
};

}  // namespace vantage
