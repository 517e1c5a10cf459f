#include "tools/handeye/handeye_run.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "perception/calibration/closed_form.h"
#include "perception/calibration/hand_pose_candidates.h"
#include "perception/calibration/image_calibration.h"
#include "perception/calibration/next_pose.h"
#include "perception/calibration/pose_calibration.h"

namespace vantage {
namespace {

constexpr double kMostOutliers = 0.5;  // Of the views; more have nothing in common.
constexpr double kLever = 0.5;         // m, as RankNextPoses() has it.

Error InvalidArgument(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message)};
}

Result<void> CheckOptions(const CalibrationInput& input, const HandEyeRunOptions& options) {
  const auto asks = [&](Estimated what) { return options.estimated.contains(what); };
  if (input.images.empty() && (asks(Estimated::kIntrinsics) || asks(Estimated::kDistortion))) {
    return InvalidArgument(
        "intrinsics and distortion show in images alone, expected --images or --log");
  }
  if (asks(Estimated::kTimeOffset) && input.trajectory.empty()) {
    return InvalidArgument(
        "the time offset shows in a log alone, where the robot's poses are known "
        "at all times, expected --log");
  }
  return {};
}

Result<HandEyeResult> Calibrate(const CalibrationInput& input, const HandEyeRunOptions& options) {
  const auto asks = [&](Estimated what) { return options.estimated.contains(what); };
  const HandTrajectory* trajectory = asks(Estimated::kTimeOffset) ? &input.trajectory : nullptr;
  if (input.images.empty()) {
    return CalibrateFromPoses(options.setup,
                              input.poses,
                              {.noise = options.noise,
                               .estimate_robot_scale = asks(Estimated::kRobotScale),
                               .trajectory = trajectory,
                               .seed = options.seed});
  }
  return CalibrateFromImages(options.setup,
                             input.images,
                             input.intrinsics->camera,
                             input.intrinsics->distortion,
                             {.noise = options.noise,
                              .estimate_focal_lengths = asks(Estimated::kIntrinsics),
                              .estimate_distortion = asks(Estimated::kDistortion),
                              .estimate_robot_scale = asks(Estimated::kRobotScale),
                              .trajectory = trajectory,
                              .seed = options.seed});
}

Pose LastHandPose(const CalibrationInput& input) {
  return input.images.empty() ? input.poses.back().T_base_hand : input.images.back().T_base_hand;
}

void JudgeFit(const HandEyeResult& result, HandEyeRun* run) {
  if (!result.observability.is_sufficient) run->refusals.push_back(result.observability.reason);
  const auto outliers = std::ranges::count_if(result.views, &ViewResidual::is_outlier);
  if (static_cast<double>(outliers) > kMostOutliers * static_cast<double>(result.views.size())) {
    run->refusals.push_back(
        Format("%td of %zu views contradict the others, expected half of them "
               "at most",
               outliers,
               result.views.size()));
  }
}

// Why a result is not to be used.
void Judge(const CalibrationInput& input, HandEyeRun* run) {
  const HandEyeResult& result = run->result;
  const InputDiagnosis& diagnosis = run->diagnosis;
  // Images of a flat target may be read in two ways, of which the calibration alone knows the right
  // one; then views contradict each other only as they were read at first.
  const bool measured = input.source == InputSource::kPosesAndImages;
  if (!diagnosis.IsSound() &&
      (!measured || !diagnosis.mistakes.empty() || !diagnosis.remarks.empty())) {
    run->refusals.push_back(diagnosis.Text());
  }
  // What poses that were read wrongly fix is of no interest.
  if (diagnosis.mistakes.empty()) JudgeFit(result, run);
  run->warnings = diagnosis.warnings;
  run->warnings.insert(run->warnings.end(), input.notes.begin(), input.notes.end());
}

double Sigma(const HandEyeCovariance& covariance) {
  return std::sqrt(kLever * kLever * covariance.topLeftCorner<3, 3>().trace() +
                   covariance.bottomRightCorner<3, 3>().trace());
}

}  // namespace

std::optional<SuggestedPose> SuggestPose(const HandEyeResult& result,
                                         const Pose& T_base_hand,
                                         const CameraModel& camera,
                                         const std::optional<CalibrationTarget>& target,
                                         const HandEyeNoise& noise) {
  const Pose T_camera_target =
      (EquationOfHand(result.setup, T_base_hand) * result.T_x).inverse() * result.T_y;
  const double distance = T_camera_target.translation().norm();
  if (!(distance > 0.01)) return std::nullopt;
  const std::vector<Pose> candidates = HandPoseCandidates(
      result.setup, result.T_x, result.T_y, distance, T_base_hand, HandPoseLimits{});
  // Without a target, poses of its origin.
  std::vector<Eigen::Vector3d> points = {Eigen::Vector3d::Zero()};
  if (target) points = TargetPoints(*target);
  const std::vector<NextPose> ranked =
      RankNextPoses(result, candidates, camera, points, noise, kLever);
  if (ranked.empty() || !ranked.front().sees_target) return std::nullopt;
  return SuggestedPose{candidates[ranked.front().candidate],
                       Sigma(result.covariance),
                       ranked.front().expected_sigma};
}

Result<HandEyeRun> RunHandEye(const CalibrationInput& input,
                              const HandEyeRunOptions& options,
                              const std::optional<CalibrationTarget>& target) {
  if (Result<void> checked = CheckOptions(input, options); !checked) return checked.error();
  HandEyeRun run;
  run.diagnosis = DiagnoseInput(options.setup, input.raw, input.source, options.seed);
  Result<HandEyeResult> result = Calibrate(input, options);
  if (!result) {
    const std::string diagnosis = run.diagnosis.Text();
    return Error{result.error().code,
                 Format("%s%s%s",
                        result.error().message.c_str(),
                        diagnosis.empty() ? "" : "; ",
                        diagnosis.c_str())};
  }
  run.result = std::move(result).value();
  Judge(input, &run);
  const std::optional<CameraModel> camera = run.result.camera ? run.result.camera
                                            : input.intrinsics
                                                ? std::optional(input.intrinsics->camera)
                                                : std::nullopt;
  if (camera && run.diagnosis.mistakes.empty()) {
    run.next = SuggestPose(run.result, LastHandPose(input), *camera, target, options.noise);
  }
  return run;
}

}  // namespace vantage
