#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "nodes/config_override.h"
#include "tools/replay/replay_run.h"

namespace vantage {

/// The configuration of a rerun.
struct ReplayConfig {
  std::string text;          ///< TOML in effect: with the overrides, and every path absolute
  std::string name;          ///< where it is from, for messages
  bool from_header = false;  ///< from the log's LOG_HEADER, not from a file
  std::string baseline;      ///< what `differences` are against, in words
  /// "fusion.sigma_deg: 4 -> 6": values in effect that are others than the baseline's, defaults
  /// included.
  std::vector<std::string> differences;

  /// From its start, as nodes need it.
  [[nodiscard]] Result<ConfigReader> Open() const { return ConfigReader::Parse(text, name); }
};

/// Finds the configuration of a rerun, and has every node of it read its tables. The baseline is
/// the log's LOG_HEADER, else the file.
/// @param options its log, estimators and with_extrinsics.
/// @param file TOML; empty: the LOG_HEADER's.
/// Errors: neither file nor LOG_HEADER; what the nodes refuse; an override that none of them reads.
Result<ReplayConfig> ResolveReplayConfig(const ReplayOptions& options,
                                         const std::string& file,
                                         const std::vector<ConfigOverride>& overrides);

}  // namespace vantage
