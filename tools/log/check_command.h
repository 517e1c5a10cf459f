#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/result.h"

namespace vantage {

/// `vantage-log check`: whether a log is as it was recorded.
class CheckCommand {
 public:
  explicit CheckCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code: 1 where something is damaged or doubtful.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string log_;
};

}  // namespace vantage
