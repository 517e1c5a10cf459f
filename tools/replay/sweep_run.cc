#include "tools/replay/sweep_run.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "common/format.h"
#include "common/rng.h"
#include "perception/model/file_bytes.h"
#include "tools/replay/replay_compare.h"
#include "tools/replay/replay_config.h"
#include "tools/replay/replay_run.h"
#include "tools/support/report_setup.h"

namespace vantage {
namespace {

// One rerun: a cell on a log.
struct Job {
  size_t cell = 0;
  size_t log = 0;
  ReplayConfig config;
};

struct JobResult {
  std::vector<SweepObject> objects;
  int num_extra = 0;
};

Error InCell(const SweepGrid& grid, size_t cell, const Error& error) {
  return {error.code, grid.CellText(cell) + ": " + error.message};
}

Result<std::vector<Job>> MakeJobs(const SweepOptions& options, const SweepGrid& grid) {
  std::vector<Job> jobs;
  for (size_t cell = 0; cell < grid.num_cells(); ++cell) {
    std::vector<ConfigOverride> overrides = options.overrides;
    for (const ConfigOverride& each : grid.Overrides(cell)) overrides.push_back(each);
    for (size_t log = 0; log < options.logs.size(); ++log) {
      if (!options.config.empty() && log > 0) {  // One file for all.
        jobs.push_back({cell, log, jobs.back().config});
        continue;
      }
      ReplayOptions replay = options.replay;
      replay.log = options.logs[log];
      Result<ReplayConfig> config = ResolveReplayConfig(replay, options.config, overrides);
      if (!config) return InCell(grid, cell, config.error());
      jobs.push_back({cell, log, std::move(config).value()});
    }
  }
  return jobs;
}

/// What a rerun is judged by. @param folder for a copy of the configuration.
Result<ReportSetup> LoadSetup(const SweepOptions& options,
                              const ReplayConfig& config,
                              const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "config.toml";
  if (Result<void> written = WriteFileBytes(file, config.text); !written) return written.error();
  Result<ReportSetup> setup = LoadReportSetup(file);
  if (!setup) return setup.error();
  if (!options.truth.empty()) {
    const Result<TruthObject> truth = ReadTruthMatrix(options.truth, options.truth_model);
    if (!truth) return truth.error();
    if (!setup->models.contains(truth->model_id)) {
      return Error{ErrorCode::kNotFound,
                   Format("--truth-model %s is no model of [models]", truth->model_id.c_str())};
    }
    setup->truth = {*truth};
  }
  if (setup->truth.empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("%s has no [[sim.object]] to judge by, expected some or --truth FILE "
                        "--truth-model NAME",
                        config.name.c_str())};
  }
  return setup;
}

Result<JobResult> RunJob(const SweepOptions& options, const Job& job) {
  Result<RecomputedLog> output = RecomputedLog::Create("");
  if (!output) return output.error();
  const Result<ReportSetup> setup = LoadSetup(options, job.config, output->file().parent_path());
  if (!setup) return setup.error();
  ReplayOptions replay = options.replay;
  replay.log = options.logs[job.log];
  replay.output = output->file();
  replay.threads = 1;
  replay.open_config = [&job] { return job.config.Open(); };
  const Result<ReplaySummary> summary = RunReplay(replay, [](double, int64_t) {});
  if (!summary) return summary.error();
  const Result<RecordedRun> run = ReadRun(output->file(), setup->camera);
  JobResult result;
  if (!run) {  // Nothing was detected.
    for (const TruthObject& each : setup->truth)
      result.objects.push_back({.model_id = each.model_id});
    return result;
  }
  const RunMetrics metrics = MeasureRun(*run, *setup);
  for (const ObjectHistory& each : metrics.objects) {
    result.objects.push_back({each.model_id,
                              each.instance.has_value(),
                              each.converged,
                              each.num_views,
                              each.final_error(),
                              each.final_refined_error()});
  }
  result.num_extra = static_cast<int>(metrics.extra.size());
  return result;
}

Interval MedianOf(const std::vector<double>& values, bool with_interval) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (values.empty() || !with_interval) return {Median(values), kNone, kNone};
  Rng rng(kSweepSeed);
  return BootstrapInterval(values, Statistic::kMedian, {}, rng);
}

SweepErrors ErrorsOf(const SweepCell& cell, std::optional<PoseError> SweepObject::*error) {
  std::vector<double> rotations;
  std::vector<double> positions;
  for (const std::vector<SweepObject>& log : cell.logs) {
    for (const SweepObject& object : log) {
      if (!(object.*error)) continue;
      rotations.push_back((object.*error)->angle / kDegree);
      positions.push_back(1e3 * (object.*error)->distance);
    }
  }
  const bool with_interval = cell.logs.size() > 1;
  return {MedianOf(rotations, with_interval), MedianOf(positions, with_interval)};
}

}  // namespace

Result<std::vector<SweepCell>> RunSweep(
    const SweepOptions& options,
    const SweepGrid& grid,
    const std::function<void(int64_t done, int64_t total)>& progress) {
  const Result<std::vector<Job>> jobs = MakeJobs(options, grid);
  if (!jobs) return jobs.error();
  SweepOptions shared = options;
  if (!shared.replay.cache) shared.replay.cache = std::make_shared<EstimatorCache>();
  std::vector<std::optional<Result<JobResult>>> results(jobs->size());
  std::atomic<size_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;
  int64_t done = 0;
  const auto work = [&] {
    for (size_t i = next++; i < jobs->size() && !failed; i = next++) {
      results[i] = RunJob(shared, (*jobs)[i]);
      if (!results[i]->ok()) failed = true;
      const std::lock_guard<std::mutex> lock(mutex);
      progress(++done, static_cast<int64_t>(jobs->size()));
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 1; i < options.replay.threads; ++i) threads.emplace_back(work);
    work();
  }
  std::vector<SweepCell> cells(grid.num_cells());
  for (size_t i = 0; i < jobs->size(); ++i) {
    const Job& job = (*jobs)[i];
    if (!results[i]) continue;  // Another one failed before.
    if (!results[i]->ok()) {
      const Error error = InCell(grid, job.cell, results[i]->error());
      return Error{error.code, options.logs[job.log] + ", " + error.message};
    }
    SweepCell& cell = cells[job.cell];
    const JobResult& result = results[i]->value();
    cell.logs.push_back(result.objects);
    cell.num_extra += result.num_extra;
    for (const SweepObject& object : result.objects) {
      ++cell.num_objects;
      if (object.found) ++cell.num_found;
    }
  }
  for (SweepCell& cell : cells) {
    cell.fused = ErrorsOf(cell, &SweepObject::fused);
    cell.refined = ErrorsOf(cell, &SweepObject::refined);
  }
  return cells;
}

}  // namespace vantage
