#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/result.h"
#include "tools/support/message_comparison.h"

namespace vantage {

/// `vantage-log compare`: whether two logs hold the same messages.
class CompareCommand {
 public:
  explicit CompareCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code: 1 where something differs.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string first_;
  std::string second_;
  std::string channels_ = "(?!LOG_HEADER$|PROCESS_STATUS$).*";
  ComparisonTolerance tolerance_;
};

}  // namespace vantage
