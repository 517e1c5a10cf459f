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

// Candidates within a mode's radius of a heavier one are one hypothesis, at their mean.
std::vector<Eigen::Quaterniond> Merge(const ConfusionModel& model,
                                      const std::vector<Candidate>& candidates) {
  struct Cluster {
    Eigen::Quaterniond seed;
    Eigen::Vector4d sum;
  };
  const SymmetryGroup& symmetry = model.symmetry();
  const double reach = std::cos(0.5 * model.parameters().mode_radius);
  std::vector<Cluster> clusters;
  for (const Candidate& candidate : candidates) {
    const Eigen::Quaterniond& q = candidate.q_world_object;
    const auto same = std::ranges::find_if(clusters, [&](const Cluster& cluster) {
      return SymmetricNearness(symmetry, q, cluster.seed) >= reach;
    });
    if (same != clusters.end()) {
      const Eigen::Vector4d near = NearestEquivalent(symmetry, q, same->seed).coeffs();
      const double sign = near.dot(same->seed.coeffs()) < 0.0 ? -1.0 : 1.0;
      same->sum += sign * candidate.weight * near;
    } else if (clusters.size() < kMostHypotheses) {
      clusters.push_back({q, candidate.weight * q.coeffs()});
    }
  }
  std::vector<Eigen::Quaterniond> hypotheses;
  for (const Cluster& cluster : clusters) {
    hypotheses.emplace_back(cluster.sum.normalized());
  }
  return hypotheses;
}

// Log of the density, relative to the uniform one, of what a view detected, if a hypothesis holds:
// a mixture of a Gaussian about each mode and of what is scattered evenly.
class ViewLikelihood {
 public:
  explicit ViewLikelihood(const ConfusionModel& model)
      : model_(model), sigma_(0.5 * model.parameters().mode_radius) {
    // Of a Gaussian in rotation vectors; SO(3) has the volume 8 pi^2 in them near the identity.
    constexpr double kPi = std::numbers::pi;
    height_ = 8.0 * kPi * kPi / (std::pow(2.0 * kPi, 1.5) * sigma_ * sigma_ * sigma_);
    reach_ = std::cos(std::min(0.5 * kCutoff * sigma_, 0.5 * kPi));
  }

  [[nodiscard]] double Log(const ConfusionView& view,
                           const Eigen::Quaterniond& q_world_object) const {
    const int direction = model_.DirectionOf(view.q_world_camera.conjugate() * q_world_object);
    const double scattered = model_.Scattered(direction);
    if (!view.q_world_object) {
      return std::log(model_.WithOutliers(std::max(0.0, model_.Missed(direction) - scattered)));
    }
    double density = model_.WithOutliers(scattered);
    const Eigen::Quaterniond difference = q_world_object.conjugate() * *view.q_world_object;
    for (int mode = 0; mode < model_.num_modes(); ++mode) {
      const double nearness =
          SymmetricNearness(model_.symmetry(), difference, model_.Difference(mode));
      if (nearness < reach_) continue;
      const double angle = AngleOfNearness(nearness);
      density += model_.WithOutliers(model_.ShareFrom(direction, mode)) * height_ *
                 std::exp(-0.5 * angle * angle / (sigma_ * sigma_));
    }
    return std::log(density);
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
  for (const Eigen::Quaterniond& q : Merge(model, Candidates(model, views))) {
    double log_posterior = 0.0;
    for (const ConfusionView& view : views) log_posterior += likelihood.Log(view, q);
    belief.push_back({Canonical(q), log_posterior});
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
