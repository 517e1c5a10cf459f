#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/log/log_import.h"
#include "tools/support/recorded_view.h"

namespace vantage {

/// `vantage-log import`: a log of a folder of recorded views.
class ImportCommand {
 public:
  explicit ImportCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// @return the exit code.
  [[nodiscard]] Result<int> Run() const;

 private:
  [[nodiscard]] Result<std::vector<RecordedView>> ListViews() const;

  CLI::App* command_;
  std::string folder_;
  std::string log_;
  std::string format_ = "auto";
  std::string compression_ = "vdc";
  std::string config_;
  std::optional<double> depth_scale_;
  std::optional<int> scene_;
  LogImportParameters parameters_;
};

}  // namespace vantage
