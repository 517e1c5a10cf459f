#include "perception/calibration/consensus.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <limits>
#include <optional>

#include "common/format.h"
#include "common/rng.h"
#include "perception/calibration/closed_form.h"

namespace vantage {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kSampleSize = 3;
constexpr int kNumSamples = 400;
constexpr int kMostRefits = 10;
/// Share of views without error that are to be taken for such.
constexpr double kKeptShare = 0.999;
/// Least noise by what is expected: below, rounding counts.
constexpr double kLeastScale = 1e-6;

/// A view as often as it has poses of the target.
struct Candidates {
  Pose A;
  Quaterniond q_a;
  std::vector<Pose> B;
  std::vector<Quaterniond> q_b;
  double rotation_variance;     ///< rad^2, about one axis
  double translation_variance;  ///< m^2, along one axis, without what robot_variance adds
  double robot_variance;        ///< rad^2, of the hand's rotation about one axis
};

Candidates MakeCandidates(HandEyeSetup setup, const PoseView& view, const HandEyeNoise& noise) {
  Candidates made;
  made.A = EquationOfHand(setup, view.T_base_hand);
  made.q_a = Quaterniond(made.A.linear());
  made.B.push_back(view.T_camera_target);
  made.B.insert(made.B.end(), view.other_T_camera_target.begin(), view.other_T_camera_target.end());
  for (const Pose& B : made.B) made.q_b.emplace_back(B.linear());
  double rotation = noise.camera_rotation * noise.camera_rotation;
  double translation = noise.camera_translation * noise.camera_translation;
  if (view.covariance) {
    rotation = view.covariance->topLeftCorner<3, 3>().trace() / 3.0;
    translation = view.covariance->bottomRightCorner<3, 3>().trace() / 3.0;
  }
  made.robot_variance = noise.robot_rotation * noise.robot_rotation;
  made.rotation_variance = rotation + made.robot_variance;
  made.translation_variance = translation + noise.robot_translation * noise.robot_translation;
  return made;
}

/// How far each view is from X and Y, and which of its poses is closest.
struct Agreement {
  std::vector<double> squared;  ///< in squared standard deviations, 6 degrees of freedom
  std::vector<int> closest;
};

class Search {
 public:
  Search(HandEyeSetup setup, std::span<const PoseView> views, const HandEyeNoise& noise)
      : setup_(setup) {
    for (const PoseView& view : views) views_.push_back(MakeCandidates(setup, view, noise));
    // The most that the least median of squares still bears of outliers, where X and Y take two
    // views (Rousseeuw, Leroy, "Robust Regression and Outlier Detection", 1987, chapter 3).
    core_size_ = std::min(views.size(), (views.size() + 3) / 2);
  }

  /// Nothing where no sample has a finite solution.
  std::optional<Consensus> Run(uint64_t seed) {
    std::vector<int> all(views_.size());
    TryAll(all);
    Rng rng(seed);
    for (int i = 0; i < kNumSamples; ++i) TrySample(rng);
    if (!std::isfinite(best_cost_)) return std::nullopt;
    return Refit();
  }

 private:
  /// The equations of views; none of those that `chosen` leaves out.
  [[nodiscard]] std::vector<HandEyeEquation> Equations(const std::vector<int>& chosen) const {
    std::vector<HandEyeEquation> equations;
    for (size_t i = 0; i < views_.size(); ++i) {
      if (chosen[i] < 0) continue;
      equations.push_back({views_[i].A, views_[i].B[static_cast<size_t>(chosen[i])]});
    }
    return equations;
  }

  void Measure(const HandEyeTransforms& solution, Agreement* agreement) const {
    const Quaterniond q_x(solution.T_x.linear());
    const Quaterniond q_y(solution.T_y.linear());
    agreement->squared.resize(views_.size());
    agreement->closest.resize(views_.size());
    for (size_t i = 0; i < views_.size(); ++i) {
      const Candidates& view = views_[i];
      const Quaterniond q_left = q_y.conjugate() * view.q_a * q_x;
      double least = std::numeric_limits<double>::infinity();
      for (size_t j = 0; j < view.B.size(); ++j) {
        const Vector3d t = view.A * (solution.T_x * view.B[j].translation());
        // The hand's rotation acts about the hand's origin.
        const Vector3d lever = setup_ == HandEyeSetup::kEyeInHand ? t - view.A.translation() : t;
        const double rotation = 4.0 * (q_left * view.q_b[j]).vec().squaredNorm();
        const double translation = (t - solution.T_y.translation()).squaredNorm();
        const double squared =
            rotation / view.rotation_variance +
            translation / (view.translation_variance +
                           (2.0 / 3.0) * view.robot_variance * lever.squaredNorm());
        if (squared < least) {
          least = squared;
          agreement->closest[i] = static_cast<int>(j);
        }
      }
      agreement->squared[i] = least;
    }
  }

  /// The distance of the farthest view of the core.
  double CoreCost(const Agreement& agreement) {
    sorted_ = agreement.squared;
    std::nth_element(
        sorted_.begin(), sorted_.begin() + static_cast<int64_t>(core_size_) - 1, sorted_.end());
    return sorted_[core_size_ - 1];
  }

  /// Takes a solution if it is the best so far, and what its core says for as long as that is
  /// better (Chum, Matas, Kittler, "Locally Optimized RANSAC", 2003).
  void Consider(const HandEyeTransforms& solution) {
    std::optional<HandEyeTransforms> next = solution;
    while (next) {
      Measure(*next, &measured_);
      const double cost = CoreCost(measured_);
      if (!(cost < best_cost_)) return;
      best_cost_ = cost;
      best_ = *next;
      next = SolvePark(Equations(Within(measured_, cost)));
    }
  }

  static std::vector<int> Within(const Agreement& agreement, double largest) {
    std::vector<int> chosen = agreement.closest;
    for (size_t i = 0; i < chosen.size(); ++i) {
      if (!(agreement.squared[i] <= largest)) chosen[i] = -1;
    }
    return chosen;
  }

  void TryAll(const std::vector<int>& chosen) {
    for (const ClosedForm& form : ClosedForms()) {
      if (const auto solution = form.solve(Equations(chosen))) Consider(*solution);
    }
  }

  void TrySample(Rng& rng) {
    size_t index[kSampleSize];
    HandEyeEquation sample[kSampleSize];
    for (int i = 0; i < kSampleSize; ++i) {
      do {
        index[i] = rng.Below(static_cast<uint32_t>(views_.size()));
      } while (std::find(index, index + i, index[i]) != index + i);
      const Candidates& view = views_[index[i]];
      sample[i] = {view.A, view.B[rng.Below(static_cast<uint32_t>(view.B.size()))]};
    }
    if (const auto solution = SolvePark(sample)) Consider(*solution);
  }

  /// The noise by what is expected: the core's size as that of a chi-square distribution with 6
  /// degrees of freedom (after Rousseeuw, Leroy, chapter 5, Eq. 1.3).
  [[nodiscard]] double SquaredScale() const {
    const boost::math::chi_squared_distribution<double> distribution(6.0);
    const double n = static_cast<double>(views_.size());
    const double share = std::min(0.9, static_cast<double>(core_size_) / n);
    const double small_sample = 1.0 + 5.0 / std::max(1.0, n - 2.0);
    const double squared_scale =
        small_sample * small_sample * best_cost_ / boost::math::quantile(distribution, share);
    return std::max(squared_scale, kLeastScale * kLeastScale);
  }

  /// All closed forms on the views that agree; those that agree with the best of them; and so on.
  Consensus Refit() {
    const double squared_scale = SquaredScale();
    const double largest =
        squared_scale *
        boost::math::quantile(boost::math::chi_squared_distribution<double>(6.0), kKeptShare);
    Consensus consensus{
        best_.T_x, best_.T_y, {}, ClosedForms().front().name, std::sqrt(squared_scale)};
    Measure(best_, &measured_);
    consensus.chosen = Within(measured_, largest);
    double best_cost = TruncatedCost(largest);
    for (int i = 0; i < kMostRefits; ++i) {
      const std::vector<HandEyeEquation> equations = Equations(consensus.chosen);
      const double cost_before = best_cost;
      for (const ClosedForm& form : ClosedForms()) {
        const std::optional<HandEyeTransforms> solution = form.solve(equations);
        if (!solution) continue;
        Measure(*solution, &measured_);
        const double cost = TruncatedCost(largest);
        if (!(cost < best_cost)) continue;
        best_cost = cost;
        consensus = {solution->T_x,
                     solution->T_y,
                     Within(measured_, largest),
                     form.name,
                     consensus.noise_scale};
      }
      if (best_cost == cost_before) break;
    }
    return consensus;
  }

  [[nodiscard]] double TruncatedCost(double largest) const {
    double cost = 0.0;
    for (const double squared : measured_.squared) cost += std::min(squared, largest);
    return cost;
  }

  HandEyeSetup setup_;
  std::vector<Candidates> views_;
  size_t core_size_;
  HandEyeTransforms best_;
  double best_cost_ = std::numeric_limits<double>::infinity();
  Agreement measured_;
  std::vector<double> sorted_;
};

}  // namespace

Result<Consensus> FindConsensus(HandEyeSetup setup,
                                std::span<const PoseView> views,
                                const HandEyeNoise& noise,
                                uint64_t seed) {
  if (views.size() < kSampleSize) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%zu views to calibrate from, expected at least %d from different poses of "
                        "the hand",
                        views.size(),
                        kSampleSize)};
  }
  Search search(setup, views, noise);
  std::optional<Consensus> consensus = search.Run(seed);
  if (!consensus) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("no three of the %zu views have a hand-eye transform in common", views.size())};
  }
  return *std::move(consensus);
}

}  // namespace vantage
