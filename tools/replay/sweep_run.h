#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/statistics.h"
#include "tools/replay/replay_options.h"
#include "tools/replay/sweep_grid.h"
#include "tools/support/run_metrics.h"

namespace vantage {

struct SweepOptions {
  ReplayOptions replay;                   ///< of every rerun; `threads`: reruns at once
  std::vector<std::string> logs{};        ///< LCM event logs
  std::string config;                     ///< TOML file; empty: each log's LOG_HEADER
  std::vector<ConfigOverride> overrides;  ///< of every cell
  std::string truth{};  ///< file with T_world_object, 4 x 4; empty: [sim] of the configuration
  std::string truth_model{};  ///< which model that is of
};

/// One object of the truth after one rerun.
struct SweepObject {
  std::string model_id;
  bool found = false;
  bool converged = false;
  int num_views = 0;
  std::optional<PoseError> fused{};    ///< of the estimate by all views
  std::optional<PoseError> refined{};  ///< of the pose refined on the depth
};

/// Medians over all objects that were found; the interval is that of the logs (bootstrap, 95 %),
/// NaN of a single log. All NaN where nothing was found.
struct SweepErrors {
  Interval rotation_deg;
  Interval position_mm;
};

struct SweepCell {
  std::vector<std::vector<SweepObject>> logs;  ///< by log, the objects of its truth in order
  int num_objects = 0;                         ///< of the truth, over all logs
  int num_found = 0;
  int num_extra = 0;  ///< confirmed estimates that no object of the truth explains
  SweepErrors fused;
  SweepErrors refined;
};

/// Reruns every log with every cell of the grid. The result is the same for any number of threads.
/// Before anything runs, all configurations are read.
/// Errors: a log; a configuration, with the cell that it is of; no truth to judge by.
Result<std::vector<SweepCell>> RunSweep(
    const SweepOptions& options,
    const SweepGrid& grid,
    const std::function<void(int64_t done, int64_t total)>& progress);

inline constexpr uint64_t kSweepSeed = 1;  ///< of the bootstrap

}  // namespace vantage
