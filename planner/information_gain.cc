#include "planner/information_gain.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/check.h"
#include "planner/outcome_table.h"

namespace vantage {
namespace {

constexpr double kAccuracyShare = 0.1;

double EntropyPart(double probability) {
  return probability > 0.0 ? -probability * std::log(probability) : 0.0;
}

std::vector<OrientationHypothesis> Weighty(std::span<const OrientationHypothesis> belief) {
  std::vector<OrientationHypothesis> hypotheses;
  double sum = 0.0;
  for (const OrientationHypothesis& hypothesis : belief) {
    if (hypotheses.size() == InformationGain::kMostHypotheses) break;
    if (hypothesis.probability < InformationGain::kLeastProbability && !hypotheses.empty()) break;
    hypotheses.push_back(hypothesis);
    sum += hypothesis.probability;
  }
  for (OrientationHypothesis& hypothesis : hypotheses) hypothesis.probability /= sum;
  return hypotheses;
}

ViewGains Gains(const PlanningState& state) {
  const size_t num_objects = state.objects.size();
  const std::vector<double> angles = AnglesToNearestVisited(state);
  ViewGains gains{std::vector<double>(state.candidates.size(), 0.0),
                  std::vector<double>(state.candidates.size() * num_objects, 0.0)};
  for (size_t object = 0; object < num_objects; ++object) {
    const PlannedObject& planned = state.objects[object];
    std::optional<InformationGain> information;
    if (planned.confusion != nullptr && !planned.belief.empty()) {
      information.emplace(*planned.confusion, planned.belief);
    }
    for (size_t i = 0; i < state.candidates.size(); ++i) {
      const double unhidden = state.Unhidden(i, object);
      const double accuracy = AccuracyGain(state.visited.size(), angles[i]);
      double gain = unhidden * accuracy;
      if (information.has_value()) {
        const InformationGain::Expected expected =
            information->From(state.candidates[i].translation() - planned.center_world, unhidden);
        gain = expected.information + kAccuracyShare * expected.detected * accuracy;
      }
      gains.by_object[i * num_objects + object] = gain;
      gains.total[i] += gain;
    }
  }
  if (num_objects > 0) return gains;
  for (size_t i = 0; i < angles.size(); ++i) {
    gains.total[i] = AccuracyGain(state.visited.size(), angles[i]);
  }
  return gains;
}

}  // namespace

InformationGain::InformationGain(const ConfusionModel& model,
                                 std::span<const OrientationHypothesis> belief)
    : model_(&model), hypotheses_(Weighty(belief)) {
  VANTAGE_CHECK(!hypotheses_.empty(), "information about an object of which there is no belief");
  const OutcomeTable table(model, hypotheses_);
  floor_.assign(table.num_outcomes(), 0.0);
  mixture_.resize(table.num_outcomes());
  for (size_t h = 0; h < hypotheses_.size(); ++h) {
    for (const int outcome : table.Of(h)) {
      outcomes_.push_back(outcome);
      floor_[static_cast<size_t>(outcome)] += hypotheses_[h].probability * model.WithOutliers(0.0);
    }
  }
}

// With the factor g, by hypothesis: mode m has the probability g WithOutliers(K_v(m)), scattered
// ones likewise, and nothing is detected with 1 - g + g WithOutliers(nothing).
InformationGain::Expected InformationGain::From(const Eigen::Vector3d& to_camera, double unhidden) {
  const double scale = unhidden * (1.0 - model_->parameters().outlier_share);
  const double unhidden_entropy = EntropyPart(unhidden);
  const auto num_modes = static_cast<size_t>(model_->num_modes());
  for (size_t i = 0; i < floor_.size(); ++i) mixture_[i] = unhidden * floor_[i];
  double scattered = 0.0;
  double missed = 0.0;
  double given = 0.0;  // Entropy of the outcomes, given the hypothesis.
  for (size_t h = 0; h < hypotheses_.size(); ++h) {
    const double b = hypotheses_[h].probability;
    const int direction =
        model_->directions().CellOf(hypotheses_[h].q_world_object.conjugate() * to_camera);
    const int* outcomes = outcomes_.data() + h * num_modes;
    for (const ConfusionModel::Share& share : model_->SharesFrom(direction)) {
      mixture_[static_cast<size_t>(outcomes[share.mode])] += b * scale * share.share;
    }
    const double scattered_share = model_->Scattered(direction);
    const double nothing =
        model_->WithOutliers(std::max(0.0, model_->Missed(direction) - scattered_share));
    const double nothing_entropy = EntropyPart(nothing);
    const double missed_here = 1.0 - unhidden + unhidden * nothing;
    const double missed_entropy = unhidden < 1.0 ? EntropyPart(missed_here) : nothing_entropy;
    scattered += b * unhidden * model_->WithOutliers(scattered_share);
    missed += b * missed_here;
    given += b * (unhidden * (model_->Entropy(direction) - nothing_entropy) +
                  (1.0 - nothing) * unhidden_entropy + missed_entropy);
  }
  double information = EntropyPart(missed) + EntropyPart(scattered) - given;
  for (const double probability : mixture_) information += EntropyPart(probability);
  return {std::max(0.0, information), 1.0 - missed - scattered};
}

ViewCriterion InformationGainView() { return {"information_gain", kNat, Gains}; }

}  // namespace vantage
