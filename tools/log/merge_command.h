#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/log/log_output.h"

namespace vantage {

/// `vantage-log merge`: one log of several, by the time of their events.
class MergeCommand {
 public:
  explicit MergeCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::vector<std::string> logs_;
  bool drop_duplicates_ = false;
  LogOutput output_;
};

}  // namespace vantage
