#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/result.h"
#include "tools/handeye/target_options.h"

namespace vantage {

/// `vantage-handeye draw-target`: a target to print.
class DrawTargetCommand {
 public:
  explicit DrawTargetCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  TargetOptions target_;
  double dots_per_inch_ = 300.0;
  std::string output_;
};

}  // namespace vantage
