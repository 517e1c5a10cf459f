#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/log/log_output.h"

namespace vantage {

/// `vantage-log filter`: a log of some of the channels of another.
class FilterCommand {
 public:
  explicit FilterCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string log_;
  std::vector<std::string> channels_;
  std::vector<std::string> exclude_;
  LogOutput output_;
};

}  // namespace vantage
