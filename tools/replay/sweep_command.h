#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common/result.h"
#include "tools/replay/sweep_run.h"

namespace vantage {

/// What of the command line is a sweep's alone.
struct SweepArguments {
  std::string file;  ///< TOML with [grid]; empty: no sweep
  std::vector<std::string> more_logs;
  std::string truth;
  std::string truth_model;
};

/// Adds the options in the group "Sweeping"; after AddReplayArguments. `arguments` outlive the
/// parsing.
void AddSweepArguments(CLI::App* app, SweepArguments* arguments);

/// Sweeps, prints the table, and writes sweep.csv, sweep.json and sweep.svg into the folder
/// `options.replay.output`, unless it is empty. Errors: RunSweep; gnuplot; the folder.
Result<void> Sweep(const SweepArguments& arguments, SweepOptions options);

}  // namespace vantage
