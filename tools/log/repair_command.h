#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/result.h"
#include "tools/log/log_output.h"

namespace vantage {

/// `vantage-log repair`: a log of the events of a damaged one that are whole.
class RepairCommand {
 public:
  explicit RepairCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string log_;
  LogOutput output_;
};

}  // namespace vantage
