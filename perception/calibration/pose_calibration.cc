#include "perception/calibration/pose_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "common/format.h"
#include "perception/calibration/consensus.h"
#include "perception/calibration/observability.h"
#include "perception/calibration/pose_adjustment.h"
#include "perception/calibration/residual_statistics.h"

namespace vantage {
namespace {

using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr int kMostRounds = 12;
constexpr size_t kFewestViews = 3;
/// Scales have settled when they change by less.
constexpr double kScaleTolerance = 0.01;
constexpr double kLeastScale = 1e-6;
constexpr double kLargestTranslation = 1e6;  // m
constexpr double kRotationTolerance = 1e-3;
constexpr double kOutlierSpread = 30.0;
/// Half of the time over which the hand's velocity is taken.
constexpr double kVelocityStep = 0.01;  // s
/// Offsets that are tried first: +- 0.5 s.
constexpr int kMostOffsetSteps = 5;
constexpr double kOffsetStep = 0.1;  // s

std::string NameOf(const PoseView& view, size_t index) {
  return view.name.empty() ? Format("view %zu", index) : view.name;
}

Result<Pose> CheckedPose(const Pose& pose, const std::string& what) {
  if (!pose.translation().allFinite() || pose.translation().norm() > kLargestTranslation) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s: translation (%g, %g, %g), expected finite numbers within %g m",
                        what.c_str(),
                        pose.translation().x(),
                        pose.translation().y(),
                        pose.translation().z(),
                        kLargestTranslation)};
  }
  const Result<Eigen::Matrix3d> rotation = ProjectToRotation(pose.linear(), kRotationTolerance);
  if (!rotation) {
    Error error = rotation.error();
    error.message.insert(0, what + ": ");
    return error;
  }
  Pose checked = Pose::Identity();
  checked.linear() = *rotation;
  checked.translation() = pose.translation();
  return checked;
}

Result<PoseView> CheckedView(const PoseView& view, size_t index) {
  const std::string name = NameOf(view, index);
  PoseView checked = view;
  const Result<Pose> hand = CheckedPose(view.T_base_hand, name + ", pose of the hand");
  if (!hand) return hand.error();
  checked.T_base_hand = *hand;
  const Result<Pose> target = CheckedPose(view.T_camera_target, name + ", pose of the target");
  if (!target) return target.error();
  checked.T_camera_target = *target;
  for (Pose& other : checked.other_T_camera_target) {
    const Result<Pose> pose = CheckedPose(other, name + ", other pose of the target");
    if (!pose) return pose.error();
    other = *pose;
  }
  if (view.covariance &&
      (!view.covariance->allFinite() || view.covariance->llt().info() != Eigen::Success)) {
    return Error{ErrorCode::kInvalidArgument,
                 name + ": covariance of the target's pose, expected positive definite"};
  }
  return checked;
}

Result<void> CheckNoise(const HandEyeNoise& noise) {
  const std::pair<const char*, double> sigmas[] = {
      {"robot_rotation", noise.robot_rotation},
      {"robot_translation", noise.robot_translation},
      {"camera_rotation", noise.camera_rotation},
      {"camera_translation", noise.camera_translation}};
  for (const auto& [name, sigma] : sigmas) {
    const bool is_camera = name[0] == 'c';
    if (std::isfinite(sigma) && (is_camera ? sigma > 0.0 : sigma >= 0.0)) continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("noise %s = %g, expected a finite number %s 0",
                        name,
                        sigma,
                        is_camera ? "above" : "of at least")};
  }
  return {};
}

HandEyeCovariance CameraCovariance(const PoseView& view, const HandEyeNoise& noise) {
  if (view.covariance) return *view.covariance;
  Vector6d sigma;
  sigma << Vector3d::Constant(noise.camera_rotation), Vector3d::Constant(noise.camera_translation);
  return sigma.cwiseAbs2().asDiagonal();
}

bool HasChanged(double scale, double before) {
  return std::abs(scale - before) > kScaleTolerance * before;
}

/// Hands at utime + offset; those of times that the trajectory does not have are left out.
std::vector<PoseView> ViewsAt(std::span<const PoseView> views,
                              const HandTrajectory& trajectory,
                              double offset) {
  std::vector<PoseView> moved;
  for (const PoseView& view : views) {
    const auto hand = trajectory.At(static_cast<double>(view.utime) + 1e6 * offset);
    if (!hand) continue;
    moved.push_back(view);
    moved.back().T_base_hand = *hand;
  }
  return moved;
}

/// The calibration of one set of views.
class Calibrator {
 public:
  Calibrator(HandEyeSetup setup,
             std::vector<PoseView> views,
             const PoseCalibrationOptions& options,
             Consensus consensus,
             double time_offset)
      : options_(options), views_(std::move(views)), chosen_(consensus.chosen) {
    problem_.setup = setup;
    problem_.noise = {options.noise.robot_rotation,
                      options.noise.robot_translation,
                      {consensus.noise_scale, consensus.noise_scale}};
    problem_.estimates_robot_scale = options.estimate_robot_scale;
    problem_.estimates_time_offset = options.trajectory != nullptr;
    state_.transforms = {consensus.T_x, consensus.T_y};
    total_offset_ = time_offset;
    method_ = std::move(consensus.method);
    for (const PoseView& view : views_) {
      AdjustmentView adjusted;
      adjusted.T_base_hand = view.T_base_hand;
      adjusted.T_camera_target = view.T_camera_target;
      adjusted.camera_covariance = CameraCovariance(view, options.noise);
      adjustment_.push_back(adjusted);
    }
    for (size_t i = 0; i < views_.size(); ++i) {
      if (chosen_[i] > 0) Choose(i, chosen_[i]);
    }
    if (problem_.estimates_time_offset) MoveHands(time_offset);
  }

  /// Takes outliers that are not far off for good views until the residuals say otherwise; whether
  /// there are any.
  bool Readmit() {
    bool has_any = false;
    for (size_t i = 0; i < views_.size(); ++i) {
      if (chosen_[i] >= 0 || ChooseClosest(i) > 6.0 * kOutlierSpread * kOutlierSpread) continue;
      chosen_[i] = closest_[i];
      has_any = true;
    }
    return has_any;
  }

  /// Adjusts and renews weights, scales and outliers in turn until they stay.
  void Settle() {
    for (int round = 0; round < kMostRounds; ++round) {
      Adjust();
      if (!Reconsider() && round > 0) return;
    }
  }

  /// -2 log likelihood but for a constant, where each outlier's error is spread over kOutlierSpread
  /// times the noise.
  [[nodiscard]] double Score() const {
    const auto outliers = static_cast<double>(std::count(chosen_.begin(), chosen_.end(), -1));
    const double freedom = 3.0 * static_cast<double>(views_.size()) - 6.0;
    return 2.0 * freedom *
               (std::log(problem_.noise.scales.rotation) +
                std::log(problem_.noise.scales.translation)) +
           12.0 * std::log(kOutlierSpread) * outliers;
  }

  HandEyeResult Finish() {
    linearization_ = Linearize(problem_, adjustment_, state_);
    statistics_ = EvaluateResiduals(linearization_, Uses(), problem_.noise.scales);
    HandEyeResult result;
    result.setup = problem_.setup;
    result.T_x = state_.transforms.T_x;
    result.T_y = state_.transforms.T_y;
    result.covariance = statistics_.covariance.block<6, 6>(0, 0);
    result.target_covariance = statistics_.covariance.block<6, 6>(6, 6);
    result.cross_covariance = statistics_.covariance.block<6, 6>(0, 6);
    result.initial_method = method_;
    SetScale(&result);
    SetViews(&result);
    SetObservability(&result);
    Eigen::Index next = 12;
    if (problem_.estimates_robot_scale) {
      result.robot_scale = state_.robot_scale;
      result.robot_scale_sigma = std::sqrt(statistics_.covariance(next, next));
      ++next;
    }
    if (problem_.estimates_time_offset) {
      result.time_offset = total_offset_;
      result.time_offset_sigma = std::sqrt(statistics_.covariance(next, next));
    }
    return result;
  }

 private:
  void Choose(size_t view, int pose) {
    chosen_[view] = pose;
    adjustment_[view].T_camera_target =
        pose <= 0 ? views_[view].T_camera_target
                  : views_[view].other_T_camera_target[static_cast<size_t>(pose) - 1];
  }

  /// Hands of a time offset, and how they change with it. Where the trajectory ends, the last
  /// velocity goes on.
  void MoveHands(double by) {
    for (size_t i = 0; i < views_.size(); ++i) {
      AdjustmentView& view = adjustment_[i];
      const double utime = static_cast<double>(views_[i].utime) + 1e6 * total_offset_;
      const auto at = options_.trajectory->At(utime);
      const auto before = options_.trajectory->At(utime - 1e6 * kVelocityStep);
      const auto after = options_.trajectory->At(utime + 1e6 * kVelocityStep);
      if (at && before && after) {
        view.T_base_hand = *at;
        const double time = 2.0 * kVelocityStep;
        view.velocity = (after->translation() - before->translation()) / time;
        view.angular_velocity =
            LogSo3(Eigen::Quaterniond(after->linear() * before->linear().transpose())) / time;
      } else {
        view.T_base_hand.linear() = ExpSo3(by * view.angular_velocity) * view.T_base_hand.linear();
        view.T_base_hand.translation() += by * view.velocity;
      }
    }
  }

  [[nodiscard]] std::vector<bool> Uses() const {
    std::vector<bool> uses;
    for (const int chosen : chosen_) uses.push_back(chosen >= 0);
    return uses;
  }

  void Adjust() {
    std::vector<AdjustmentView> used;
    for (size_t i = 0; i < adjustment_.size(); ++i) {
      if (chosen_[i] >= 0) used.push_back(adjustment_[i]);
    }
    state_ = AdjustPoses(problem_, used, state_);
    if (!problem_.estimates_time_offset) return;
    const double by = std::exchange(state_.time_offset, 0.0);
    total_offset_ += by;
    has_moved_ = std::abs(by) > 1e-6;
    MoveHands(by);
  }

  /// Renews scales and outliers; whether anything has changed.
  bool Reconsider() {
    std::vector<bool> uses = Uses();
    for (size_t i = 0; i < views_.size(); ++i) ChooseClosest(i);
    linearization_ = Linearize(problem_, adjustment_, state_);
    const ResidualScales before = problem_.noise.scales;
    statistics_ = EvaluateResiduals(linearization_, uses, before);
    ResidualScales& scales = problem_.noise.scales;
    scales = {std::max(kLeastScale, statistics_.scales.rotation),
              std::max(kLeastScale, statistics_.scales.translation)};
    bool has_changed = has_moved_ || HasChanged(scales.rotation, before.rotation) ||
                       HasChanged(scales.translation, before.translation);
    const auto num_kept =
        std::count(statistics_.is_outlier.begin(), statistics_.is_outlier.end(), false);
    if (num_kept < static_cast<int64_t>(kFewestViews)) return false;
    for (size_t i = 0; i < views_.size(); ++i) {
      if (statistics_.is_outlier[i] != uses[i]) continue;
      has_changed = true;
      chosen_[i] = statistics_.is_outlier[i] ? -1 : closest_[i];
    }
    return has_changed;
  }

  /// Takes the pose of a view that the present estimate likes best, an outlier stays one.
  /// @return its squared deviation, 6 degrees of freedom.
  double ChooseClosest(size_t view) {
    closest_.resize(views_.size(), 0);
    const bool is_used = chosen_[view] >= 0;
    int best = 0;
    double least = 0.0;
    for (int pose = 0; pose <= static_cast<int>(views_[view].other_T_camera_target.size());
         ++pose) {
      Choose(view, pose);
      const HandEyeCovariance covariance = ViewErrorCovariance(problem_, adjustment_[view], state_);
      const Vector6d error = ViewError(problem_.setup, adjustment_[view], state_);
      const double squared = error.dot(covariance.llt().solve(error));
      if (pose > 0 && !(squared < least)) continue;
      best = pose;
      least = squared;
    }
    Choose(view, best);
    closest_[view] = best;
    if (!is_used) chosen_[view] = -1;
    return least;
  }

  void SetScale(HandEyeResult* result) const {
    const ResidualScales& scales = problem_.noise.scales;
    result->noise_scale = std::sqrt(
        0.5 * (scales.rotation * scales.rotation + scales.translation * scales.translation));
    const double rotation = statistics_.rotation_freedom;
    const double translation = statistics_.translation_freedom;
    // Of two scales the one that rests on less.
    const double freedom = scales.rotation == scales.translation ? rotation + translation
                                                                 : std::min(rotation, translation);
    const boost::math::fisher_f_distribution<double> distribution(6.0, std::max(1.0, freedom));
    result->squared_radius_95 = 6.0 * boost::math::quantile(distribution, 0.95);
  }

  void SetViews(HandEyeResult* result) const {
    Eigen::Vector4d sums = Eigen::Vector4d::Zero();
    double count = 0.0;
    for (size_t i = 0; i < views_.size(); ++i) {
      ViewResidual view;
      view.name = views_[i].name;
      const Vector6d error = ViewError(problem_.setup, adjustment_[i], state_);
      view.rotation = error.head<3>().norm();
      view.translation = error.tail<3>().norm();
      const auto row = 6 * static_cast<Eigen::Index>(i);
      view.deviation = linearization_.residuals.segment<6>(row).norm() / std::sqrt(6.0);
      view.is_outlier = chosen_[i] < 0;
      if (!view.is_outlier) {
        const AdjustmentState others =
            Moved(problem_, state_, StepWithout(linearization_, statistics_, i));
        const Vector6d left_out = ViewError(problem_.setup, adjustment_[i], others);
        view.left_out_rotation = left_out.head<3>().norm();
        view.left_out_translation = left_out.tail<3>().norm();
        sums +=
            Eigen::Vector4d(
                view.rotation, view.translation, view.left_out_rotation, view.left_out_translation)
                .cwiseAbs2();
        count += 1.0;
      }
      result->views.push_back(view);
    }
    const Eigen::Vector4d rms = (sums / std::max(1.0, count)).cwiseSqrt();
    result->rotation_rms = rms[0];
    result->translation_rms = rms[1];
    result->left_out_rotation_rms = rms[2];
    result->left_out_translation_rms = rms[3];
  }

  void SetObservability(HandEyeResult* result) const {
    std::vector<Pose> hands;
    for (size_t i = 0; i < adjustment_.size(); ++i) {
      if (chosen_[i] >= 0) hands.push_back(adjustment_[i].T_base_hand);
    }
    result->observability = AssessObservability(
        problem_.setup, hands, result->covariance, problem_.noise.robot_rotation);
  }

  const PoseCalibrationOptions& options_;
  std::vector<PoseView> views_;
  std::vector<int> chosen_;  ///< of each view's poses; -1: it is an outlier
  std::vector<int> closest_;
  std::vector<AdjustmentView> adjustment_;
  AdjustmentProblem problem_;
  AdjustmentState state_;
  AdjustmentLinearization linearization_;
  ResidualStatistics statistics_;
  std::string method_;
  double total_offset_ = 0.0;  ///< s
  bool has_moved_ = false;     ///< in time
};

struct Start {
  Consensus consensus;
  double time_offset = 0.0;  ///< s
};

/// Of several time offsets the one whose views agree best.
Result<Start> FindStart(HandEyeSetup setup,
                        std::vector<PoseView>* views,
                        const PoseCalibrationOptions& options) {
  if (options.trajectory == nullptr) {
    Result<Consensus> consensus = FindConsensus(setup, *views, options.noise, options.seed);
    if (!consensus) return consensus.error();
    return Start{std::move(consensus).value(), 0.0};
  }
  for (size_t i = 0; i < views->size(); ++i) {
    PoseView& view = (*views)[i];
    const auto hand = options.trajectory->At(static_cast<double>(view.utime));
    if (view.utime == 0 || !hand) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("%s: utime %lld is not within the robot's poses, which the time offset "
                          "needs",
                          NameOf(view, i).c_str(),
                          static_cast<long long>(view.utime))};
    }
    view.T_base_hand = *hand;
  }
  Result<Consensus> consensus = FindConsensus(setup, *views, options.noise, options.seed);
  if (!consensus) return consensus.error();
  Start best{std::move(consensus).value(), 0.0};
  for (int step = -kMostOffsetSteps; step <= kMostOffsetSteps; ++step) {
    const double offset = kOffsetStep * step;
    std::vector<PoseView> moved = ViewsAt(*views, *options.trajectory, offset);
    if (step == 0 || moved.size() < views->size()) continue;
    Result<Consensus> other = FindConsensus(setup, moved, options.noise, options.seed);
    if (!other || !(other->noise_scale < best.consensus.noise_scale)) continue;
    best = {std::move(other).value(), offset};
  }
  return best;
}

}  // namespace

Result<HandEyeResult> CalibrateFromPoses(HandEyeSetup setup,
                                         std::span<const PoseView> views,
                                         const PoseCalibrationOptions& options) {
  if (const Result<void> valid = CheckNoise(options.noise); !valid) return valid.error();
  std::vector<PoseView> checked;
  for (size_t i = 0; i < views.size(); ++i) {
    Result<PoseView> view = CheckedView(views[i], i);
    if (!view) return view.error();
    checked.push_back(std::move(view).value());
  }
  Result<Start> start = FindStart(setup, &checked, options);
  if (!start) return start.error();
  Calibrator calibrator(
      setup, std::move(checked), options, std::move(start->consensus), start->time_offset);
  calibrator.Settle();
  // Few views agree among themselves by chance: leaving out fewer may be as good.
  Calibrator with_more = calibrator;
  if (!with_more.Readmit()) return calibrator.Finish();
  with_more.Settle();
  return with_more.Score() < calibrator.Score() ? with_more.Finish() : calibrator.Finish();
}

}  // namespace vantage
