#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/result.h"
#include "tools/log/log_output.h"

namespace vantage {

/// `vantage-log cut`: a log of a stretch of time of another.
class CutCommand {
 public:
  explicit CutCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string log_;
  std::string from_;
  std::string to_;
  LogOutput output_;
};

}  // namespace vantage
