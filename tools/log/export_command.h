#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/log/log_exporter.h"

namespace vantage {

/// `vantage-log export`: what is in a log, as files of other kinds.
class ExportCommand {
 public:
  explicit ExportCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  [[nodiscard]] Result<std::unique_ptr<LogExporter>> MakeExporter() const;

  CLI::App* command_;
  std::string log_;
  std::string output_;
  std::string format_;
  std::vector<std::string> channels_;
  std::vector<std::string> exclude_;
  std::string from_;
  std::string to_;
  bool merge_ = false;
};

}  // namespace vantage
