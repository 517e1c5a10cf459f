#pragma once

#include <span>
#include <vector>

#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/mode_belief.h"

namespace vantage {

/// What may be detected of an object, if any: every hypothesis q may be reported as q q'_m, by each
/// mode's difference rotation. Reports of different hypotheses within the modes' radius of each
/// other, modulo the object's symmetry, can't be told apart: they are one outcome. Modes of one
/// hypothesis are always told apart. No outcome depends on where the camera is.
class OutcomeTable {
 public:
  OutcomeTable(const ConfusionModel& model, std::span<const OrientationHypothesis> hypotheses);

  /// Index of the outcome that a hypothesis leads to by each mode.
  [[nodiscard]] std::span<const int> Of(size_t hypothesis) const {
    return std::span(outcomes_).subspan(hypothesis * num_modes_, num_modes_);
  }
  [[nodiscard]] size_t num_outcomes() const { return num_outcomes_; }

 private:
  size_t num_modes_;
  size_t num_outcomes_ = 0;
  std::vector<int> outcomes_;
};

}  // namespace vantage
