#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "common/result.h"
#include "perception/calibration/calibration_target.h"

namespace vantage {

/// A calibration target as a command line describes it: a TOML file, or kind and sizes.
class TargetOptions {
 public:
  /// Adds --target and what belongs to it.
  void AddTo(CLI::App* command);
  /// Nothing where no --target was said. Errors: the file, as ReadTarget(); a target that is not
  /// valid; sizes without --target.
  [[nodiscard]] Result<std::optional<CalibrationTarget>> Read() const;

 private:
  std::string target_;
  std::optional<int> columns_;
  std::optional<int> rows_;
  std::optional<int> first_id_;
  std::optional<double> size_;
  std::optional<double> gap_;
  std::optional<double> marker_;
  std::optional<std::string> family_;
};

}  // namespace vantage
