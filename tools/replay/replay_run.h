#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/log_bus.h"
#include "common/result.h"
#include "tools/replay/replay_options.h"
#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {

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
/// Errors: the log, the configuration, the models, or the output; nothing in the log of what is
/// asked for. Then no output is left behind.
Result<ReplaySummary> RunReplay(const ReplayOptions& options, const ReplayProgress& progress);

}  // namespace vantage
