#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/mode_belief.h"
#include "fusion/final_orientation.h"
#include "fusion/mode_refinement.h"
#include "fusion/orientation_fusion.h"
#include "fusion/orientation_histogram.h"
#include "fusion/orientation_prior.h"
#include "fusion/orientation_view.h"
#include "fusion/peaks.h"
#include "fusion/so3_grid.h"

namespace vantage {

/// Parameters of the histogram filter (paper section 5).
struct OrientationFilterParameters {
  double sigma_cw = 4.0 * kDegree;  ///< rad, of the confidence weight (eq. 2)
  double sigma_vw = 6.25e-6;        ///< m^2, of the verification weight (eq. 4): (2.5 mm)^2
  /// rad, >= 0, by which each change of the viewpoint turns what was seen before, in each of three
  /// axes: errors of the robot's poses. The paper leaves this out, its robot being precise.
  double sigma_motion = 0.0;
  FinalOrientation final_orientation = FinalOrientation::kDensityMode;
  PeakParameters peaks{};
  ModeRefinementParameters mode{};
  double converge_angle = 1.0 * kDegree;  ///< rad, change of q_f that counts as none (paper 5.2)
  int converge_views = 2;                 ///< last views that must not have changed q_f
  int min_views = 4;                      ///< views before convergence is believed

  Result<void> Validate() const;
};

/// What is known of one object beside its views.
struct OrientationKnowledge {
  OrientationPrior prior{};  ///< of the filter's grid
  /// Orientations that it makes equal are one to the density's mode and to convergence.
  SymmetryGroup symmetry = SymmetryGroup::None();
  /// What the estimator takes for what; outlives the filter; null: not measured. Used of views that
  /// know their camera, by kCwVwClustering and kDensityMode.
  const ConfusionModel* confusion = nullptr;
};

/// The histogram filter: the orientation of one object, fused from one detection a view.
///
/// With a confusion model a detection q_D is added at each truth q_D q'* that it may stand for,
/// with the share of the mode q' from where that truth is seen: the accuracy weights of paper 6.1
/// free of the grid (with the identity as the only mode, the confidence weights). Their sum (eq.
/// 10) never leaves one mode of several, since a right detection of an ambiguous side speaks for
/// the alternatives too. So the peaks then are those of the belief, the product of the same
/// weights: their weight is a probability, and less likely ones are left out (paper Fig. 16).
class OrientationFilter : public OrientationFusion {
 public:
  /// @param grid outlives the filter. @param parameters valid.
  OrientationFilter(const So3Grid& grid,
                    const OrientationFilterParameters& parameters,
                    OrientationKnowledge knowledge = {});

  /// Fuses one more view, at the cost of an update; with sigma_motion > 0, which widens what was
  /// seen before, at that of all views so far.
  Result<void> Add(const OrientationView& view) override;
  /// Fuses all views of the object, in their order. Steps over views that are as in the last call
  /// are not repeated: a new last view costs one update, a changed one those from there on.
  /// @param views valid; checked.
  void Fuse(const std::vector<OrientationView>& views);

  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;
  [[nodiscard]] const OrientationHistogram& histogram() const { return histogram_; }
  /// Modes, best first; empty while no view has weight. OrientationPeak::weight is a share of the
  /// histogram's mass, with a belief() the probability of the hypotheses that the peak stands for;
  /// peaks below w_mode times the best one's then are left out.
  [[nodiscard]] const std::vector<OrientationPeak>& peaks() const { return peaks_; }
  /// The posterior over the truths that the views allow, best first; empty without a confusion
  /// model.
  [[nodiscard]] const std::vector<OrientationHypothesis>& belief() const { return belief_; }
  /// Angle between the last two q_f, modulo symmetry, rad; -1 while there are none.
  [[nodiscard]] double last_change() const;
  /// The termination condition of paper 5.2.
  [[nodiscard]] bool converged() const;

 private:
  void AddToHistogram(const OrientationView& view, double sigma_motion);
  void AddDetection(const OrientationView& view, double sigma_motion, double w_v);
  void AddKernels(const std::vector<OrientationKernel>& kernels, const std::vector<double>& w_v);
  [[nodiscard]] double Support(const Eigen::Quaterniond& q) const;
  void FuseAll();
  void FindFinalOrientation();
  void RefinePeaks();
  [[nodiscard]] OrientationPeak AtMode(OrientationPeak peak) const;
  [[nodiscard]] std::vector<ConfusionView> ViewsOfBelief() const;
  void WeighByBelief();
  [[nodiscard]] OrientationPeak PeakOf(const OrientationHypothesis& hypothesis) const;
  [[nodiscard]] Eigen::Quaterniond HeaviestCell() const;
  // Angle between q_f so many views ago and the one before, rad; -1 where either is none.
  [[nodiscard]] double ChangeAt(int age) const;

  const So3Grid* grid_;
  OrientationFilterParameters parameters_;
  OrientationKnowledge knowledge_;
  OrientationHistogram histogram_;
  std::vector<OrientationView> views_;
  std::vector<OrientationKernel> kernels_;  // Of views with weight.
  std::vector<double> support_;             // w_v of each.
  size_t last_view_ = 0;                    // First kernel of the last view.
  std::vector<OrientationPeak> peaks_;
  std::vector<OrientationHypothesis> belief_;
  std::vector<std::optional<Eigen::Quaterniond>> q_f_;  // After each view; none without weight.
};

/// q_f of the same views by each of the five ways, in the order of kFinalOrientations. Errors: a
/// view that is not valid, none that has weight.
Result<std::vector<Eigen::Quaterniond>> AllFinalOrientations(
    const So3Grid& grid,
    const OrientationFilterParameters& parameters,
    std::span<const OrientationView> views);

}  // namespace vantage
