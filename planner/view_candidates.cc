#include "planner/view_candidates.h"

#include <cmath>
#include <numbers>

#include "common/format.h"

namespace vantage {
namespace {

constexpr int kMostViews = 10'000;

Pose ViewFrom(const ViewCandidateParameters& parameters, double azimuth, double elevation) {
  const Eigen::Vector3d direction(std::cos(azimuth) * std::cos(elevation),
                                  std::sin(azimuth) * std::cos(elevation),
                                  std::sin(elevation));
  return LookAt(parameters.target + parameters.radius * direction, parameters.target);
}

std::vector<Pose> SpreadEvenly(const ViewCandidateParameters& parameters) {
  const double lowest_z = std::sin(parameters.lowest_elevation);
  const double highest_z = std::sin(parameters.highest_elevation);
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Pose> candidates;
  for (int i = 0; i < parameters.count; ++i) {
    const double z = lowest_z + (highest_z - lowest_z) * (i + 0.5) / parameters.count;
    candidates.push_back(ViewFrom(parameters, i * golden_angle, std::asin(z)));
  }
  return candidates;
}

}  // namespace

Result<void> ViewCandidateParameters::Validate() const {
  if (!target.allFinite() || !(radius > 0.0 && std::isfinite(radius))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("target = (%g, %g, %g) m and radius = %g m, expected finite numbers and a "
                        "radius above 0",
                        target.x(),
                        target.y(),
                        target.z(),
                        radius)};
  }
  constexpr double kSteepest = std::numbers::pi / 2.0 + 1e-9;
  if (!(lowest_elevation >= -kSteepest && lowest_elevation <= highest_elevation &&
        highest_elevation <= kSteepest)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("elevations from %g to %g degrees, expected -90 <= lowest <= highest <= 90",
                        lowest_elevation / kDegree,
                        highest_elevation / kDegree)};
  }
  if (count < 0 || count > kMostViews) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%d views, expected 0..%d, 0 for rings", count, kMostViews)};
  }
  if (num_elevations < 1 || num_azimuths < 1 || num_elevations > 90 || num_azimuths > 360) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%d elevations and %d azimuths, expected 1..90 and 1..360",
                        num_elevations,
                        num_azimuths)};
  }
  return {};
}

std::vector<Pose> MakeViewCandidates(const ViewCandidateParameters& parameters) {
  if (parameters.count > 0) return SpreadEvenly(parameters);
  std::vector<Pose> candidates;
  for (int ring = 0; ring < parameters.num_elevations; ++ring) {
    const double share =
        parameters.num_elevations > 1 ? 1.0 * ring / (parameters.num_elevations - 1) : 0.0;
    const double elevation = parameters.lowest_elevation +
                             share * (parameters.highest_elevation - parameters.lowest_elevation);
    const bool is_pole = std::cos(elevation) < 1e-6;
    for (int step = 0; step < (is_pole ? 1 : parameters.num_azimuths); ++step) {
      const double azimuth = 2.0 * std::numbers::pi * step / parameters.num_azimuths;
      candidates.push_back(ViewFrom(parameters, azimuth, elevation));
    }
  }
  return candidates;
}

}  // namespace vantage
