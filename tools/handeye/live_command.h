#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "common/result.h"

namespace vantage {

/// `vantage-handeye live`: calibrates with the robot that is on the bus, and writes the file that
/// [extrinsics] names.
class LiveCommand {
 public:
  explicit LiveCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code: 1 when the motions did not fix the calibration, or it is farther from a
  /// simulation's truth than was allowed.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string config_;
  std::string url_;
  std::optional<double> max_error_mm_;
  std::optional<double> max_error_deg_;
};

}  // namespace vantage
