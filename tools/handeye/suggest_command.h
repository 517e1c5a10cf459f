#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/handeye/target_options.h"

namespace vantage {

/// `vantage-handeye suggest`: where to take the next view to sharpen a calibration.
class SuggestCommand {
 public:
  explicit SuggestCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string calibration_;
  std::vector<double> hand_;  // x y z, qw qx qy qz
  TargetOptions target_;
};

}  // namespace vantage
