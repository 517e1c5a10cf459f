#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "common/result.h"
#include "tools/replay/replay_options.h"
#include "tools/support/log_comparison.h"

namespace vantage {

/// What a rerun is compared with, and how.
struct ReplayCompareOptions {
  bool with_recorded = false;  ///< with what the log itself holds
  std::string other;           ///< log; empty: none
  ComparisonTolerance tolerance;

  [[nodiscard]] bool IsAsked() const { return with_recorded || !other.empty(); }
};

/// Adds the options in the group "Comparing". After AddReplayArguments; `options` outlives the
/// parsing.
void AddReplayCompareArguments(CLI::App* app, ReplayCompareOptions* options);

/// A log for what is recomputed: the one that was asked for, else a temporary one, gone with this.
class RecomputedLog {
 public:
  /// Errors: no temporary folder can be made.
  static Result<RecomputedLog> Create(const std::string& output);
  ~RecomputedLog();
  RecomputedLog(RecomputedLog&& other) noexcept;
  RecomputedLog& operator=(RecomputedLog&&) = delete;

  [[nodiscard]] std::filesystem::path file() const { return file_; }

 private:
  RecomputedLog() = default;
  std::filesystem::path file_;
  std::filesystem::path folder_;  // Empty: nothing to remove.
};

/// Compares what a rerun made. Errors: the logs; nothing there to compare.
Result<LogComparison> CompareRerun(const ReplayOptions& options,
                                   const ReplayCompareOptions& compare,
                                   const std::filesystem::path& recomputed);

}  // namespace vantage
