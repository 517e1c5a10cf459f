#include "tools/handeye/calibrate_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <system_error>

#include "common/format.h"
#include "nodes/handeye_file.h"
#include "tools/handeye/handeye_report.h"
#include "tools/handeye/pose_file.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int kRefused = 1;  // Exit code.

Error InvalidArgument(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message)};
}

const std::map<std::string, Estimated>& Estimates() {
  static const std::map<std::string, Estimated> names = {{"intrinsics", Estimated::kIntrinsics},
                                                         {"distortion", Estimated::kDistortion},
                                                         {"robot-scale", Estimated::kRobotScale},
                                                         {"time-offset", Estimated::kTimeOffset}};
  return names;
}

Result<void> CheckNoise(const char* option, const std::vector<double>& sigmas) {
  const bool valid = std::ranges::all_of(sigmas, [](double s) { return s >= 1e-6 && s <= 1e3; });
  if (valid) return {};
  return InvalidArgument(Format("%s, expected standard deviations from 1e-6 to 1000", option));
}

int64_t LastUtime(const CalibrationInput& input) {
  int64_t last = 0;
  for (const RawView& view : input.raw) last = std::max(last, view.utime);
  for (const PoseView& view : input.poses) last = std::max(last, view.utime);
  return last;
}

}  // namespace

CalibrateCommand::CalibrateCommand(CLI::App* app)
    : command_(app->add_subcommand("calibrate", "find where the camera is fixed")) {
  command_->add_option("--setup", setup_, "where the camera is: eye-in-hand or eye-to-hand")
      ->required()
      ->check(CLI::IsMember({"eye-in-hand", "eye-to-hand"}));
  command_->add_option("--poses", poses_, "pairs of poses: FILE.csv or FILE.json");
  command_->add_option("--images", images_.folder, "folder with images and poses of the robot");
  command_->add_option("--image-pattern", images_.image_pattern, "such as image-%d.png");
  command_->add_option("--pose-pattern", images_.pose_pattern, "such as pose_%d.yaml");
  command_->add_option("--log", log_.log, "LCM event log with images and poses of the robot");
  command_->add_option("--camera", log_.camera, "the <NAME> of the camera's channels")
      ->default_val("CAMERA");
  command_->add_option("--hand-channel", log_.hand_channel, "of T_base_hand in a log")
      ->capture_default_str();
  command_->add_option("--detections",
                       detections_,
                       "channel of object detections in a log, in "
                       "place of a target");
  command_->add_option("--model", model_, "folder of the object that is detected");
  target_options_.AddTo(command_);
  command_->add_option(
      "--intrinsics", intrinsics_, "of the camera: TOML as of its driver, or ViSP's XML");
  command_->add_option("--robot-noise", robot_noise_, "standard deviations, deg and mm")
      ->expected(2)
      ->capture_default_str();
  command_->add_option("--camera-noise", camera_noise_, "of target poses, deg and mm")
      ->expected(2)
      ->capture_default_str();
  command_->add_option("--pixel-noise", pixel_noise_, "of points in images, px")
      ->capture_default_str();
  command_
      ->add_option("--estimate", estimate_, "too: intrinsics, distortion, robot-scale, time-offset")
      ->delimiter(',')
      ->check(CLI::IsMember({"intrinsics", "distortion", "robot-scale", "time-offset"}));
  command_->add_option("--seed", seed_, "of the search for views that agree")
      ->capture_default_str();
  command_->add_option("--output", output_, "folder for handeye.toml, residuals and report.html");
}

Result<void> CalibrateCommand::ReadOptions() {
  options_.setup = setup_ == "eye-in-hand" ? HandEyeSetup::kEyeInHand : HandEyeSetup::kEyeToHand;
  if (auto checked = CheckNoise("--robot-noise", robot_noise_); !checked) return checked;
  if (auto checked = CheckNoise("--camera-noise", camera_noise_); !checked) return checked;
  if (auto checked = CheckNoise("--pixel-noise", {pixel_noise_}); !checked) return checked;
  options_.noise = {.robot_rotation = robot_noise_[0] * kDegree,
                    .robot_translation = 1e-3 * robot_noise_[1],
                    .camera_rotation = camera_noise_[0] * kDegree,
                    .camera_translation = 1e-3 * camera_noise_[1],
                    .pixel = pixel_noise_};
  for (const std::string& name : estimate_) options_.estimated.insert(Estimates().at(name));
  options_.seed = seed_;
  const int num_inputs =
      (poses_.empty() ? 0 : 1) + (images_.folder.empty() ? 0 : 1) + (log_.log.empty() ? 0 : 1);
  if (num_inputs != 1) {
    return InvalidArgument("expected one of --poses FILE, --images FOLDER and --log FILE");
  }
  if (detections_.empty() != model_.empty()) {
    return InvalidArgument("expected --detections CHANNEL and --model FOLDER together");
  }
  if (!detections_.empty() && log_.log.empty()) {
    return InvalidArgument("--detections are in a log, expected --log FILE");
  }
  log_.in_motion = options_.estimated.contains(Estimated::kTimeOffset);
  const Result<std::optional<CalibrationTarget>> target = target_options_.Read();
  if (!target) return target.error();
  target_ = *target;
  return {};
}

Result<CalibrationInput> CalibrateCommand::ReadInput() const {
  std::optional<CameraIntrinsics> intrinsics;
  if (!intrinsics_.empty()) {
    const Result<CameraIntrinsics> read = ReadIntrinsics(intrinsics_);
    if (!read) return read.error();
    intrinsics = *read;
  }
  if (!poses_.empty()) {
    Result<std::vector<RawView>> views = ReadPoseFile(poses_);
    if (!views) return views.error();
    Result<CalibrationInput> input =
        InputFromPoses(options_.setup, std::move(views).value(), options_.seed);
    if (!input)
      return Error{input.error().code,
                   Format("%s: %s", poses_.c_str(), input.error().message.c_str())};
    input->intrinsics = intrinsics;
    return input;
  }
  if (!log_.log.empty()) return ReadLog(intrinsics);
  if (!target_) return InvalidArgument("--images without a target, expected --target");
  if (!intrinsics)
    return InvalidArgument("--images without the camera, expected --intrinsics FILE");
  return InputFromFolder(images_, *target_, *intrinsics, options_.noise.pixel);
}

Result<CalibrationInput> CalibrateCommand::ReadLog(
    const std::optional<CameraIntrinsics>& intrinsics) const {
  if (!detections_.empty()) return InputFromDetections(log_, detections_, model_);
  if (!target_) {
    return InvalidArgument(
        "--log without a target, expected --target, or --detections with --model");
  }
  return InputFromLogImages(log_, *target_, intrinsics, options_.noise.pixel);
}

Result<void> CalibrateCommand::WriteFiles(const CalibrationInput& input,
                                          const HandEyeRun& run) const {
  const fs::path folder = output_;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  if (run.refusals.empty()) {
    HandEyeFile file = MakeHandEyeFile(run.result, log_.camera, LastUtime(input));
    if (!file.intrinsics && input.intrinsics) {
      file.intrinsics = input.intrinsics->camera;
      file.distortion = input.intrinsics->distortion;
    }
    if (auto written = WriteHandEyeFile(file, folder / "handeye.toml"); !written) return written;
    std::printf("\nwrote %s\n", (folder / "handeye.toml").c_str());
    if (options_.estimated.contains(Estimated::kIntrinsics) && file.intrinsics) {
      const std::string text = IntrinsicsToml({*file.intrinsics, file.distortion});
      if (auto written = WriteWholeFile(folder / "camera.toml", text); !written) return written;
      std::printf("wrote %s\n", (folder / "camera.toml").c_str());
    }
  } else if (fs::exists(folder / "handeye.toml", error)) {
    std::printf("\n%s is of an earlier calibration and left as it was\n",
                (folder / "handeye.toml").c_str());
  }
  if (auto written = WriteWholeFile(folder / "residuals.csv", ResidualsCsv(run.result)); !written) {
    return written;
  }
  const Result<std::string> figure = ResidualFigure(run.result);
  if (!figure) return figure.error();
  if (auto written = WriteWholeFile(folder / "residuals.svg", *figure); !written) return written;
  const std::string page =
      HandEyePage(Format("Hand-eye calibration of %s", log_.camera.c_str()), run, *figure);
  if (auto written = WriteWholeFile(folder / "report.html", page); !written) return written;
  std::printf("wrote %s\n", (folder / "report.html").c_str());
  return {};
}

Result<int> CalibrateCommand::Run() {
  if (Result<void> read = ReadOptions(); !read) return read.error();
  const Result<CalibrationInput> input = ReadInput();
  if (!input) return input.error();
  const Result<HandEyeRun> run = RunHandEye(*input, options_, target_);
  if (!run) return run.error();
  std::fputs(HandEyeText(*run).c_str(), stdout);
  if (!output_.empty()) {
    if (Result<void> written = WriteFiles(*input, *run); !written) return written.error();
  }
  return run->refusals.empty() ? 0 : kRefused;
}

}  // namespace vantage
