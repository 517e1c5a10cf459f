#pragma once

#include <deque>
#include <string>

#include "common/result.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

struct DriftCheckParameters {
  HandEyeNoise noise;
  /// Of the calibration: residuals by what was expected of them. Noise counts with it.
  double noise_scale = 1.0;
  int window = 24;             ///< views that are looked at, of them the latest 3, 6, 12, ... too
  int least_views = 3;         ///< before it is said that the calibration holds
  double false_alarms = 0.01;  ///< how often a false alarm comes in 1,000 views
  double distortion_ratio = 1.5;  ///< pixel rms by the calibrated one, from which lens or focal
                                  ///< length are doubted

  Result<void> Validate() const;
};

/// What was seen from one place of the hand.
struct DriftView {
  Pose T_base_hand = Pose::Identity();
  Pose T_camera_target = Pose::Identity();
  /// As PoseView::covariance.
  HandEyeCovariance camera_covariance = HandEyeCovariance::Identity();
  /// Which thing was seen: 0 is the target that was calibrated with; others are objects that lie
  /// still, of which the first view tells roughly where.
  int reference = 0;
  double pixel_rms = 0.0;  ///< px, of the target's points; 0: none
};

struct DriftReport {
  enum class State { kUnknown, kHolds, kDrifted, kDistorted };
  State state = State::kUnknown;
  int num_views = 0;               ///< that it rests on
  double rotation = 0.0;           ///< rad, by which the camera seems to have turned
  double rotation_sigma = 0.0;     ///< rad, of that if nothing has moved
  double translation = 0.0;        ///< m
  double translation_sigma = 0.0;  ///< m
  double pixel_rms = 0.0;          ///< px
  std::string reason;              ///< what is wrong and what to do
};

/// Watches whether a calibration holds: over windows of the latest views the common error of X that
/// explains their residuals best is estimated together with where the things seen are, and tested
/// against what robot, camera and calibration allow (a window-limited generalized likelihood ratio
/// test: Willsky, Jones 1976; Lai, "Sequential changepoint detection in quality control and
/// dynamical systems", JRSS B 1995). The level is divided by the windows and tests (Bonferroni).
class DriftCheck {
 public:
  /// @param calibration of which setup, X, Y, their covariances and squared_radius_95 count.
  /// @param pixel_rms px, of the calibration; 0: none, and pixels are not looked at.
  DriftCheck(const DriftCheckParameters& parameters,
             const HandEyeResult& calibration,
             double pixel_rms);

  /// A view of a hand that rests; it takes the place of the latest one of the same thing if the
  /// hand has not moved since: a robot errs the same way while it rests, so that several images
  /// from there tell no more than one.
  void Add(const DriftView& view);
  [[nodiscard]] DriftReport Report() const;

 private:
  struct Estimate;
  [[nodiscard]] Estimate Fit(size_t num_views, bool camera_moves, bool target_moves) const;
  [[nodiscard]] Pose ReferencePose(int reference) const;

  DriftCheckParameters parameters_;
  HandEyeResult calibration_;
  double pixel_rms_;
  double threshold_;
  std::deque<DriftView> views_;                  // The latest last.
  std::deque<std::pair<int, Pose>> references_;  // Where objects are, by the first view of each.
};

}  // namespace vantage
