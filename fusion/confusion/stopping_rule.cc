#include "fusion/confusion/stopping_rule.h"

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "common/check.h"
#include "common/format.h"
#include "common/parameter_text.h"
#include "fusion/confusion/confidence_sequence.h"

namespace vantage {

Result<void> StoppingParameters::Validate() const {
  constexpr int kMostTrials = 100'000;
  const auto error = [](const char* name, double value, const char* expected) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is %g, expected %s", name, value, expected)};
  };
  const auto is_share = [](double value) { return value > 0.0 && value < 1.0; };
  if (least_trials < 1) return error("least_trials", least_trials, "at least 1");
  if (most_trials < least_trials || most_trials > kMostTrials) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("most_trials is %d, expected least_trials, which is %d, up to %d",
                        most_trials,
                        least_trials,
                        kMostTrials)};
  }
  if (!is_share(largest_confusion)) {
    return error("largest_confusion", largest_confusion, "a share above 0 and below 1");
  }
  if (!is_share(widest)) return error("widest", widest, "a width above 0 and below 1");
  if (!is_share(alpha)) return error("alpha", alpha, "a probability above 0 and below 1");
  if (!(mode_radius > 0.0 && mode_radius <= std::numbers::pi)) {
    return error("mode_radius", mode_radius, "an angle above 0 and up to pi rad");
  }
  return {};
}

std::string StoppingParameters::Text() const {
  ParameterText text;
  text.Line("least_trials", least_trials);
  text.Line("most_trials", most_trials);
  text.Line("largest_confusion", largest_confusion);
  text.Line("widest", widest);
  text.Line("alpha", alpha);
  text.Line("mode_radius", mode_radius);
  return text.text();
}

StoppingRule::StoppingRule(const StoppingParameters& parameters, const SymmetryGroup& symmetry)
    : parameters_(parameters), symmetry_(symmetry) {
  VANTAGE_CHECK(parameters.Validate().ok(), "parameters of a stopping rule");
}

void StoppingRule::Add(const std::optional<Eigen::Quaterniond>& difference) {
  VANTAGE_CHECK(!difference || difference->coeffs().allFinite(), "a difference is finite");
  ++num_trials_;
  if (!difference) {
    ++num_missed_;
    return;
  }
  Mode* nearest = nullptr;
  double least = parameters_.mode_radius;
  for (Mode& mode : modes_) {
    const double angle = SymmetricAngle(symmetry_, *difference, mode.first_member);
    if (angle > least || (nearest != nullptr && angle == least)) continue;
    least = angle;
    nearest = &mode;
  }
  if (nearest != nullptr) {
    ++nearest->count;
  } else {
    modes_.push_back({*difference});
  }
}

bool StoppingRule::IsDone() const {
  if (num_trials_ < parameters_.least_trials) return false;
  if (num_trials_ >= parameters_.most_trials) return true;
  if (ConfidenceSequence(0, num_trials_, parameters_.alpha).high >= parameters_.largest_confusion) {
    return false;
  }
  int nearest_to_half = num_missed_;  // Its share is known least.
  for (const Mode& mode : modes_) {
    if (std::abs(2 * mode.count - num_trials_) < std::abs(2 * nearest_to_half - num_trials_)) {
      nearest_to_half = mode.count;
    }
  }
  const Interval share = ConfidenceSequence(nearest_to_half, num_trials_, parameters_.alpha);
  return share.high - share.low < parameters_.widest;
}

}  // namespace vantage
