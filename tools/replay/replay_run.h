#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/log_bus.h"
#include "common/result.h"
#include "nodes/config_reader.h"
#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {

/// What is rerun, on what, and where the result goes.
struct ReplayOptions {
  std::string log;     ///< LCM event log
  std::string output;  ///< log for what is recomputed; empty: none
  std::vector<std::string> estimators = {"ppf"};
  bool with_inputs = false;      ///< copy what is read into the output too
  bool with_extrinsics = false;  ///< camera poses anew too, from HAND_TO_BASE
  /// The configuration, from its start: every node takes its own tables of it. Called on the
  /// thread that runs the rerun alone.
  std::function<Result<ConfigReader>()> open_config;
};

/// What came of a rerun.
struct ReplaySummary {
  object_estimates_v3_t objects{};  ///< the last OBJECTS
  LogBus::Counters counters;
  EventLogReader::Damage damage;
  double span = 0.0;  ///< s of log time
  /// What whoever trusts the result should know, a sentence each.
  std::vector<std::string> warnings;
};

/// Called after every event. @param share of the log that was read, [0, 1].
using ReplayProgress = std::function<void(double share, int64_t num_events)>;

/// Reruns estimators and fusion on a log: the node objects of the live processes on a LogBus. Any
/// number of reruns may run at once, each on a thread of its own; none prints.
/// Errors: the log, the configuration, the models, or the output.
Result<ReplaySummary> RunReplay(const ReplayOptions& options, const ReplayProgress& progress);

}  // namespace vantage
