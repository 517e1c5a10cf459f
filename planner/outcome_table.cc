#include "planner/outcome_table.h"

#include <cmath>

#include "fusion/confusion/symmetric_nearness.h"

namespace vantage {
namespace {

// Reports that stand for the outcomes, each the first of its kind.
class FirstReports {
 public:
  explicit FirstReports(const ConfusionModel& model)
      : symmetry_(model.symmetry()), reach_(std::cos(0.5 * model.parameters().mode_radius)) {}

  // The nearest outcome within reach that `hypothesis` does not lead to yet, otherwise a new one.
  int Assign(const Eigen::Quaterniond& q, size_t hypothesis) {
    double most = reach_;
    size_t nearest = reports_.size();
    for (size_t i = 0; i < reports_.size(); ++i) {
      if (reports_[i].last_hypothesis == hypothesis) continue;
      const double nearness = SymmetricNearness(symmetry_, q, reports_[i].q);
      if (nearness <= most) continue;
      most = nearness;
      nearest = i;
    }
    if (nearest == reports_.size()) {
      reports_.push_back({q, hypothesis});
    } else {
      reports_[nearest].last_hypothesis = hypothesis;
    }
    return static_cast<int>(nearest);
  }

  [[nodiscard]] size_t size() const { return reports_.size(); }

 private:
  struct Report {
    Eigen::Quaterniond q;
    size_t last_hypothesis;
  };
  const SymmetryGroup& symmetry_;
  double reach_;
  std::vector<Report> reports_;
};

}  // namespace

OutcomeTable::OutcomeTable(const ConfusionModel& model,
                           std::span<const OrientationHypothesis> hypotheses)
    : num_modes_(static_cast<size_t>(model.num_modes())) {
  FirstReports firsts(model);
  outcomes_.reserve(hypotheses.size() * num_modes_);
  for (size_t h = 0; h < hypotheses.size(); ++h) {
    for (int mode = 0; mode < model.num_modes(); ++mode) {
      outcomes_.push_back(firsts.Assign(hypotheses[h].q_world_object * model.Difference(mode), h));
    }
  }
  num_outcomes_ = firsts.size();
}

}  // namespace vantage
