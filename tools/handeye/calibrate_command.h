#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/handeye/handeye_run.h"
#include "tools/handeye/image_folder.h"
#include "tools/handeye/log_input.h"
#include "tools/handeye/target_options.h"

namespace vantage {

/// `vantage-handeye calibrate`: from poses, images or a log to handeye.toml and a report.
class CalibrateCommand {
 public:
  explicit CalibrateCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code: 1 where the calibration must not be used, whose handeye.toml is then
  /// not written.
  Result<int> Run();

 private:
  [[nodiscard]] Result<CalibrationInput> ReadInput() const;
  [[nodiscard]] Result<CalibrationInput> ReadLog(
      const std::optional<CameraIntrinsics>& intrinsics) const;
  Result<void> ReadOptions();
  Result<void> WriteFiles(const CalibrationInput& input, const HandEyeRun& run) const;

  CLI::App* command_;
  std::string setup_;
  std::string poses_;
  ImageFolderLayout images_;
  LogSelection log_;
  std::string detections_;
  std::string model_;
  TargetOptions target_options_;
  std::optional<CalibrationTarget> target_;
  std::string intrinsics_;
  std::vector<double> robot_noise_ = {0.02, 0.1};  // deg, mm
  std::vector<double> camera_noise_ = {0.1, 0.5};  // deg, mm
  double pixel_noise_ = 0.2;                       // px
  std::vector<std::string> estimate_;
  uint64_t seed_ = 1;
  std::string output_;
  HandEyeRunOptions options_;
};

}  // namespace vantage
