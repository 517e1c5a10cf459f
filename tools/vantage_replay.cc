// vantage-replay: reruns estimators and fusion on a log in one process, without loss and as fast
// as they compute.

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/format.h"
#include "nodes/command_line.h"
#include "nodes/config_override.h"
#include "tools/replay/replay_arguments.h"
#include "tools/replay/replay_compare.h"
#include "tools/replay/replay_config.h"
#include "tools/replay/replay_run.h"
#include "tools/replay/sweep_command.h"
#include "tools/support/object_table.h"
#include "tools/support/shown_progress.h"

namespace vantage {
namespace {

constexpr int kBadInput = 2;

struct Arguments {
  ReplayOptions replay;
  ReplayCompareOptions compare;
  SweepArguments sweep;
  std::string config;
  std::vector<std::string> settings;
};

int Fail(const Error& error) {
  std::fprintf(stderr, "vantage-replay: %s\n", error.message.c_str());
  return kBadInput;
}

Result<std::vector<ConfigOverride>> ParseSettings(const std::vector<std::string>& settings) {
  std::vector<ConfigOverride> overrides;
  for (const std::string& setting : settings) {
    const Result<ConfigOverride> parsed = ParseConfigOverride(setting);
    if (!parsed) return Error{parsed.error().code, "--set " + parsed.error().message};
    overrides.push_back(*parsed);
  }
  return overrides;
}

/// An output in the place of a log that is read would be the end of it.
Result<void> CheckOutput(const Arguments& arguments) {
  for (const std::string& log : {arguments.replay.log, arguments.compare.other}) {
    std::error_code absent;
    if (!std::filesystem::equivalent(log, arguments.replay.output, absent)) continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("--output %s is a log that is read, expected another file", log.c_str())};
  }
  return {};
}

void PrintConfig(const ReplayConfig& config) {
  if (config.from_header) {
    std::fprintf(stderr, "vantage-replay: configuration from the log's LOG_HEADER\n");
  }
  if (config.differences.empty()) return;
  std::fprintf(stderr, "other than in %s:\n", config.baseline.c_str());
  for (const std::string& line : config.differences) std::fprintf(stderr, "  %s\n", line.c_str());
}

void PrintSummary(const ReplaySummary& summary, double seconds) {
  std::printf("%s", ObjectTable(summary.objects).c_str());
  std::printf("%jd events of %.1f s in %.1f s (%.1f times as fast as it was recorded)\n",
              intmax_t{summary.counters.num_events},
              summary.span,
              seconds,
              seconds > 0.0 ? summary.span / seconds : 0.0);
  for (const auto& [channel, count] : summary.counters.decode_errors) {
    std::printf("%s: %jd messages could not be decoded\n", channel.c_str(), intmax_t{count});
  }
  for (const std::string& warning : summary.warnings) std::printf("warning: %s\n", warning.c_str());
  if (summary.damage.any()) std::printf("damage: %s\n", summary.damage.Describe().c_str());
}

Result<ReplaySummary> Rerun(const ReplayOptions& options) {
  // Counted in kilobytes of the log: how many events it has, only its end tells.
  std::error_code ignored;
  const auto bytes = static_cast<double>(std::filesystem::file_size(options.log, ignored));
  const auto total = static_cast<int64_t>(2.0 + bytes / 1e3);
  ShownProgress progress("kB");
  return RunReplay(options, [&](double share, int64_t) {
    // All is done when the answers to the last event are, too.
    progress.Show(static_cast<int64_t>(share * static_cast<double>(total - 1)), total);
  });
}

int Run(const Arguments& arguments) {
  ReplayOptions options = arguments.replay;
  const Result<std::vector<ConfigOverride>> overrides = ParseSettings(arguments.settings);
  if (!overrides) return Fail(overrides.error());
  if (!arguments.sweep.file.empty()) {
    const Result<void> swept = Sweep(
        arguments.sweep, {.replay = options, .config = arguments.config, .overrides = *overrides});
    return swept ? 0 : Fail(swept.error());
  }
  if (Result<void> checked = CheckOutput(arguments); !checked) return Fail(checked.error());
  const Result<ReplayConfig> config = ResolveReplayConfig(options, arguments.config, *overrides);
  if (!config) return Fail(config.error());
  options.open_config = [&config] { return config->Open(); };
  std::optional<RecomputedLog> recomputed;
  if (arguments.compare.IsAsked()) {
    Result<RecomputedLog> created = RecomputedLog::Create(options.output);
    if (!created) return Fail(created.error());
    recomputed.emplace(std::move(created).value());
    options.output = recomputed->file();
  }
  PrintConfig(*config);
  const auto start = std::chrono::steady_clock::now();
  const Result<ReplaySummary> summary = Rerun(options);
  if (!summary) return Fail(summary.error());
  PrintSummary(*summary,
               std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  if (!recomputed) return 0;
  const Result<LogComparison> comparison =
      CompareRerun(options, arguments.compare, recomputed->file());
  if (!comparison) return Fail(comparison.error());
  const char* other = arguments.compare.other.empty() ? "recorded" : "other";
  std::printf("\n%s", ComparisonText(*comparison, {other, "recomputed"}).c_str());
  return comparison->clean() ? 0 : 1;
}

int Main(int argc, char** argv) {
  CLI::App app("Reruns estimators and fusion on a log, in one process and without loss",
               "vantage-replay");
  Arguments arguments;
  AddReplayArguments(&app, &arguments.replay);
  app.add_option("--config,-c",
                 arguments.config,
                 "TOML file of the set-up; default: the one in the log's LOG_HEADER")
      ->group("Configuration");
  app.add_option("--set",
                 arguments.settings,
                 "table.key=value, goes before the configuration's; may be given often")
      ->allow_extra_args(false)
      ->group("Configuration");
  AddReplayCompareArguments(&app, &arguments.compare);
  AddSweepArguments(&app, &arguments.sweep);
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  return Run(arguments);
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Main(argc, argv); }
