#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "fusion/confusion/trial_count.h"

namespace vantage {

/// When enough trials were made from one viewing direction.
struct StoppingParameters {
  int least_trials = 24;              ///< at least so many
  int most_trials = kPaperNumTrials;  ///< never more; equal to least_trials: always so many
  /// Not enough while trials that all agree could not yet show that other outcomes have a share
  /// below this: 69 trials.
  double largest_confusion = 0.08;
  /// Then enough when the share of every outcome is known to so much, from end to end: at once with
  /// few outcomes outside one mode, after about 120 trials with two modes of one half each.
  double widest = 0.3;
  double alpha = 0.05;                  ///< of each confidence sequence
  double mode_radius = 10.0 * kDegree;  ///< rad, differences that near are of one mode

  Result<void> Validate() const;
  /// For ContingencyKey::stopping: equal texts, equal parameters.
  [[nodiscard]] std::string Text() const;
};

/// Told the outcome of one trial after the other from one viewing direction, says when there are
/// enough. Its confidence sequences hold at all times, so that looking after each trial does not
/// favor chance agreement. What it says depends on the outcomes and their order alone.
class StoppingRule {
 public:
  StoppingRule(const StoppingParameters& parameters, const SymmetryGroup& symmetry);

  /// @param difference q_GT* q_D of the next trial; none: nothing was detected, an outcome of its
  /// own.
  void Add(const std::optional<Eigen::Quaterniond>& difference);
  [[nodiscard]] bool IsDone() const;

  [[nodiscard]] int num_trials() const { return num_trials_; }
  /// Modes so far, modulo the object's symmetry: a difference is of the nearest mode whose first
  /// member lies within mode_radius, or founds one.
  [[nodiscard]] int num_modes() const { return static_cast<int>(modes_.size()); }

 private:
  struct Mode {
    Eigen::Quaterniond first_member;
    int count = 1;
  };

  StoppingParameters parameters_;
  SymmetryGroup symmetry_;
  std::vector<Mode> modes_;
  int num_trials_ = 0;
  int num_missed_ = 0;
};

}  // namespace vantage
