#include "fusion/mode_refinement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "common/format.h"

namespace vantage {
namespace {

// Median length of a normal vector in three dimensions with standard deviation 1 in each.
constexpr double kMedianLength = 1.538;
// Detections beyond this many sigma of the mode are of another one.
constexpr double kReach = 2.5;
constexpr int kRounds = 5;

// Robust standard deviation of the detections about a mode in each axis, rad: by the weighted
// median of their angles.
double Scatter(std::span<const OrientationKernel> detections,
               const Eigen::Quaterniond& mode,
               double reach) {
  std::vector<std::pair<double, double>> angles;  // And weights.
  double total = 0.0;
  for (const OrientationKernel& detection : detections) {
    const double angle = GeodesicAngle(detection.q, mode);
    if (angle > reach) continue;
    angles.emplace_back(angle, detection.weight);
    total += detection.weight;
  }
  std::sort(angles.begin(), angles.end());
  double below = 0.0;
  for (const auto& [angle, weight] : angles) {
    below += weight;
    if (below >= 0.5 * total) return angle / kMedianLength;
  }
  return 0.0;
}

}  // namespace

Result<void> ModeRefinementParameters::Validate() const {
  if (!(sigma > 0.0 && sigma <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma = %g rad, expected above 0 and at most pi", sigma)};
  }
  if (!(bandwidth >= 0.0 && bandwidth <= 100.0)) {
    return Error{ErrorCode::kInvalidArgument, Format("bandwidth = %g, expected 0..100", bandwidth)};
  }
  if (!(smallest_sigma > 0.0 && smallest_sigma <= sigma)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("smallest_sigma = %g rad, expected above 0 and at most sigma = %g rad",
                        smallest_sigma,
                        sigma)};
  }
  if (!(mse_floor > 0.0 && std::isfinite(mse_floor))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("mse_floor = %g m^2, expected above 0", mse_floor)};
  }
  return {};
}

double PrecisionWeight(double mse, const ModeRefinementParameters& parameters) {
  return 1e-6 / (mse + parameters.mse_floor);
}

DensityMode RefineMode(std::span<const OrientationKernel> detections,
                       const Eigen::Quaterniond& start,
                       const ModeRefinementParameters& parameters,
                       const SymmetryGroup& symmetry) {
  std::vector<OrientationKernel> kernels(detections.begin(), detections.end());
  const auto place_kernels = [&](const Eigen::Quaterniond& reference, double sigma) {
    for (size_t i = 0; i < kernels.size(); ++i) {
      kernels[i].q = NearestEquivalent(symmetry, detections[i].q, reference);
      kernels[i].sigma = std::hypot(sigma, detections[i].sigma);
    }
  };
  place_kernels(start, parameters.sigma);
  DensityMode mode = FindDensityMode(kernels, start);
  if (parameters.bandwidth <= 0.0) return mode;
  const double reach = kReach * parameters.sigma;
  for (int round = 0; round < kRounds; ++round) {
    place_kernels(mode.q, parameters.sigma);
    const double scatter = Scatter(kernels, mode.q, reach);
    place_kernels(
        mode.q,
        std::clamp(parameters.bandwidth * scatter, parameters.smallest_sigma, parameters.sigma));
    mode = FindDensityMode(kernels, mode.q);
  }
  return mode;
}

}  // namespace vantage
