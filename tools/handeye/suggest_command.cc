#include "tools/handeye/suggest_command.h"

#include <array>
#include <cstdio>
#include <optional>

#include "common/format.h"
#include "nodes/handeye_file.h"
#include "tools/handeye/handeye_report.h"
#include "tools/handeye/handeye_run.h"

namespace vantage {

SuggestCommand::SuggestCommand(CLI::App* app)
    : command_(app->add_subcommand("suggest", "say where to take the next view")) {
  command_->add_option("calibration", calibration_, "a handeye.toml with intrinsics")->required();
  command_->add_option("--hand", hand_, "T_base_hand to start from: x y z (m) qw qx qy qz")
      ->expected(7)
      ->required();
  target_.AddTo(command_);
}

Result<int> SuggestCommand::Run() const {
  const Result<HandEyeFile> file = ReadHandEyeFile(calibration_);
  if (!file) return file.error();
  if (!file->intrinsics) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s has no [intrinsics], expected them to know what the camera sees",
                        calibration_.c_str())};
  }
  const std::array<double, 3> t = {hand_[0], hand_[1], hand_[2]};
  const std::array<double, 4> q = {hand_[3], hand_[4], hand_[5], hand_[6]};
  const Result<Pose> T_base_hand = PoseFromWire(t, q);
  if (!T_base_hand) {
    return Error{T_base_hand.error().code,
                 Format("--hand: %s", T_base_hand.error().message.c_str())};
  }
  const Result<std::optional<CalibrationTarget>> target = target_.Read();
  if (!target) return target.error();
  HandEyeResult result;
  result.setup = file->setup;
  result.T_x = file->T_x;
  result.T_y = file->T_y;
  result.covariance = file->covariance;
  result.target_covariance = file->target_covariance;
  result.cross_covariance = file->cross_covariance;
  result.noise_scale = file->noise_scale;
  const std::optional<SuggestedPose> next =
      SuggestPose(result, *T_base_hand, *file->intrinsics, *target, HandEyeNoise{});
  if (!next) {
    return Error{ErrorCode::kNotFound,
                 "no pose about --hand shows the whole target, expected the target in view"};
  }
  std::printf("%s\n", PoseNumbers(next->T_base_hand).c_str());
  std::printf(
      "standard deviation of X %.3f mm, after a view from there %.3f mm (rotation at 0.5 m)\n",
      1e3 * next->sigma_now,
      1e3 * next->sigma_after);
  return 0;
}

}  // namespace vantage
