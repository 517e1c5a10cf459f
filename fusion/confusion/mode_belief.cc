#include "fusion/confusion/mode_belief.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fusion/confusion/symmetric_nearness.h"

namespace vantage {
namespace {

constexpr size_t kMostHypotheses = 400;
constexpr double kLeastProbability = 1e-6;
constexpr double kCutoff = 5.0;  // Standard deviations.

struct Candidate {
  Eigen::Quaterniond q_world_object;
  double weight;
};

// Truths that the detections may stand for, each with its share.
std::vector<Candidate> Candidates(const ConfusionModel& model,
                                  const std::vector<ConfusionView>& views) {
  std::vector<Candidate> candidates;
  for (const ConfusionView& view : views) {
    if (!view.q_world_object) continue;
    for (int mode = 0; mode < model.num_modes(); ++mode) {
      const Eigen::Quaterniond truth = *view.q_world_object * model.Difference(mode).conjugate();
      const int direction = model.DirectionOf(view.q_world_camera.conjugate() * truth);
      const double share = model.ShareFrom(direction, mode);
      // The detection itself may be right even where it never was.
      if (mode == 0 || share > 0.0) candidates.push_back({truth, model.WithOutliers(share)});
    }
  }
  std::stable_sort(candidates.begin(),
                   candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.weight > b.weight; });
  return candidates;
}

// Sum of orientations that are near each other modulo symmetry.
struct NearbySum {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();

  void Add(const SymmetryGroup& symmetry,
           const Eigen::Quaterniond& q,
           const Eigen::Quaterniond& reference) {
    const Eigen::Vector4d near = NearestEquivalent(symmetry, q, reference).coeffs();
    sum += near.dot(reference.coeffs()) < 0.0 ? Eigen::Vector4d(-near) : near;
  }
};

// Candidates within a mode's radius of a heavier one are one hypothesis.
std::vector<Eigen::Quaterniond> Merge(const ConfusionModel& model,
                                      const std::vector<Candidate>& candidates) {
  const double reach = std::cos(0.5 * model.parameters().mode_radius);
  std::vector<Eigen::Quaterniond> hypotheses;
  for (const Candidate& candidate : candidates) {
    if (hypotheses.size() == kMostHypotheses) break;
    const bool apart = std::ranges::none_of(hypotheses, [&](const Eigen::Quaterniond& other) {
      return SymmetricNearness(model.symmetry(), candidate.q_world_object, other) >= reach;
    });
    if (apart) hypotheses.push_back(candidate.q_world_object);
  }
  return hypotheses;
}

// The orientation about a hypothesis that all detections together speak for, each by the mode that
// it is nearest to: the same whatever their shares, so that equally good alternatives stay so.
Eigen::Quaterniond Centered(const ConfusionModel& model,
                            const std::vector<ConfusionView>& views,
                            const Eigen::Quaterniond& hypothesis) {
  NearbySum sum;
  for (const ConfusionView& view : views) {
    if (!view.q_world_object) continue;
    const int mode = model.ModeOf(hypothesis.conjugate() * *view.q_world_object);
    if (mode < 0) continue;
    sum.Add(
        model.symmetry(), *view.q_world_object * model.Difference(mode).conjugate(), hypothesis);
  }
  const double norm = sum.sum.norm();
  return norm > 0.0 ? Eigen::Quaterniond(Eigen::Vector4d(sum.sum / norm)) : hypothesis;
}

// Density, relative to the uniform one, of what a view detected, if a hypothesis holds: a mixture
// of a Gaussian about each mode and of what is scattered evenly.
class ViewLikelihood {
 public:
  explicit ViewLikelihood(const ConfusionModel& model)
      : model_(model), sigma_(0.5 * model.parameters().mode_radius) {
    // Of a Gaussian in rotation vectors; SO(3) has the volume 8 pi^2 in them near the identity.
    constexpr double kPi = std::numbers::pi;
    height_ = 8.0 * kPi * kPi / (std::pow(2.0 * kPi, 1.5) * sigma_ * sigma_ * sigma_);
    reach_ = std::cos(std::min(0.5 * kCutoff * sigma_, 0.5 * kPi));
  }

  struct Terms {
    double scattered = 0.0;  // Of a look that found nothing: its probability.
    double modes = 0.0;
  };
  [[nodiscard]] Terms Of(const ConfusionView& view,
                         const Eigen::Quaterniond& q_world_object) const {
    const int direction = model_.DirectionOf(view.q_world_camera.conjugate() * q_world_object);
    const double scattered = model_.Scattered(direction);
    if (!view.q_world_object) {
      return {model_.WithOutliers(std::max(0.0, model_.Missed(direction) - scattered)), 0.0};
    }
    Terms terms{model_.WithOutliers(scattered), 0.0};
    const Eigen::Quaterniond difference = q_world_object.conjugate() * *view.q_world_object;
    for (int mode = 0; mode < model_.num_modes(); ++mode) {
      const double nearness =
          SymmetricNearness(model_.symmetry(), difference, model_.Difference(mode));
      if (nearness < reach_) continue;
      const double angle = AngleOfNearness(nearness);
      terms.modes += model_.WithOutliers(model_.ShareFrom(direction, mode)) * height_ *
                     std::exp(-0.5 * angle * angle / (sigma_ * sigma_));
    }
    return terms;
  }

  // Log of the posterior's integral over the orientations about a hypothesis: where n detections
  // are near its modes, it is a Gaussian with 1 / n of their variance in three axes.
  [[nodiscard]] double LogPosterior(const std::vector<ConfusionView>& views,
                                    const Eigen::Quaterniond& q_world_object) const {
    double log_posterior = 0.0;
    double num_near = 0.0;
    for (const ConfusionView& view : views) {
      const Terms terms = Of(view, q_world_object);
      const double density = terms.scattered + terms.modes;
      log_posterior += std::log(density);
      num_near += terms.modes / density;
    }
    return log_posterior - 1.5 * std::log(std::max(1.0, num_near));
  }

 private:
  const ConfusionModel& model_;
  double sigma_;   // rad.
  double height_;  // Of a mode's Gaussian, relative to the uniform density.
  double reach_;   // Nearness beyond which it counts as 0.
};

}  // namespace

std::vector<OrientationHypothesis> ModeBelief(const ConfusionModel& model,
                                              const std::vector<ConfusionView>& views) {
  std::vector<OrientationHypothesis> belief;
  const ViewLikelihood likelihood(model);
  for (const Eigen::Quaterniond& hypothesis : Merge(model, Candidates(model, views))) {
    const Eigen::Quaterniond q = Centered(model, views, hypothesis);
    belief.push_back(
        {Canonical(q), likelihood.LogPosterior(views, q)});  // A logarithm until below.
  }
  if (belief.empty()) return belief;
  std::stable_sort(belief.begin(), belief.end(), [](const auto& a, const auto& b) {
    return a.probability > b.probability;
  });
  const double largest = belief.front().probability;
  const auto normalize = [&] {
    double sum = 0.0;
    for (const OrientationHypothesis& one : belief) sum += one.probability;
    for (OrientationHypothesis& one : belief) one.probability /= sum;
  };
  for (OrientationHypothesis& one : belief) one.probability = std::exp(one.probability - largest);
  normalize();
  std::erase_if(belief, [](const auto& one) { return one.probability < kLeastProbability; });
  normalize();
  return belief;
}

double BeliefEntropy(const std::vector<OrientationHypothesis>& belief) {
  double entropy = 0.0;
  for (const OrientationHypothesis& one : belief) {
    if (one.probability > 0.0) entropy -= one.probability * std::log(one.probability);
  }
  return std::max(0.0, entropy);
}

}  // namespace vantage
