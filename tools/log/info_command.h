#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/result.h"

namespace vantage {

/// `vantage-log info`: what is in a log.
class InfoCommand {
 public:
  explicit InfoCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  CLI::App* command_;
  std::string log_;
  bool json_ = false;
};

}  // namespace vantage
