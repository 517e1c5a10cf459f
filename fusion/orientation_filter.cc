#include "fusion/orientation_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/format.h"
#include "fusion/verification_weight.h"

namespace vantage {

Result<void> OrientationFilterParameters::Validate() const {
  if (!(sigma_cw > 0.0 && sigma_cw <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma_cw = %g rad, expected above 0 and at most pi", sigma_cw)};
  }
  if (!(sigma_vw > 0.0 && std::isfinite(sigma_vw))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma_vw = %g m^2, expected above 0", sigma_vw)};
  }
  if (!(converge_angle > 0.0) || converge_views < 1 || min_views < 1) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("converge_angle = %g rad, converge_views = %d, min_views = %d, expected "
                        "all above 0",
                        converge_angle,
                        converge_views,
                        min_views)};
  }
  return peaks.Validate();
}

OrientationFilter::OrientationFilter(const So3Grid& grid,
                                     const OrientationFilterParameters& parameters)
    : grid_(&grid), parameters_(parameters), histogram_(grid) {}

void OrientationFilter::Fuse(std::vector<OrientationView> views) {
  const auto [changed, old] =
      std::mismatch(views.begin(), views.end(), views_.begin(), views_.end());
  const auto num_same = static_cast<size_t>(changed - views.begin());
  // What was added can't be taken back without rounding: start again from the first view.
  if (num_same < views_.size()) histogram_ = OrientationHistogram(*grid_);
  const size_t first = num_same < views_.size() ? 0 : num_same;
  q_f_.resize(num_same);
  for (size_t i = first; i < views.size(); ++i) {
    const double w_v = VerificationWeight(views[i].mse, parameters_.sigma_vw);
    if (w_v > 0.0) histogram_.Add(views[i].q_world_object, parameters_.sigma_cw, w_v);
    if (i < num_same) continue;
    peaks_ = FindPeaks(histogram_, parameters_.peaks);
    q_f_.push_back(peaks_.empty() ? Eigen::Quaterniond::Identity() : peaks_.front().q);
  }
  if (num_same == views.size() && num_same < views_.size()) {
    peaks_ = FindPeaks(histogram_, parameters_.peaks);
  }
  views_ = std::move(views);
}

double OrientationFilter::last_change() const {
  if (q_f_.size() < 2) return -1.0;
  return GeodesicAngle(q_f_[q_f_.size() - 2], q_f_.back());
}

bool OrientationFilter::converged() const {
  const auto needed =
      static_cast<size_t>(std::max(parameters_.converge_views + 1, parameters_.min_views));
  if (peaks_.empty() || q_f_.size() < needed) return false;
  for (int i = 0; i < parameters_.converge_views; ++i) {
    const auto last = q_f_.end() - 1 - i;
    if (!(GeodesicAngle(*(last - 1), *last) < parameters_.converge_angle)) return false;
  }
  return true;
}

}  // namespace vantage
