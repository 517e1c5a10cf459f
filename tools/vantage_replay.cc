// vantage-replay: reruns estimators and fusion on a log in one process, without loss and as fast
// as they compute.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "nodes/command_line.h"
#include "tools/replay/replay_arguments.h"
#include "tools/replay/replay_run.h"
#include "tools/support/log_config.h"
#include "tools/support/object_table.h"

namespace vantage {
namespace {

class Progress {
 public:
  void Show(double share, int64_t num_events) {
    if (isatty(STDERR_FILENO) == 0) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    std::fprintf(stderr, "\r%3.0f %%  %jd events", 100.0 * share, intmax_t{num_events});
  }
  void Clear() {
    if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r%40s\r", "");
  }
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_{};
};

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
  if (summary.damage.any()) std::printf("damage: %s\n", summary.damage.Describe().c_str());
}

int Run(int argc, char** argv) {
  CLI::App app("Reruns estimators and fusion on a log, in one process and without loss",
               "vantage-replay");
  ReplayOptions options;
  std::string config;
  AddReplayArguments(&app, &options);
  app.add_option(
      "--config,-c", config, "TOML file of the set-up; default: the one in the log's LOG_HEADER");
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  options.open_config = [&] { return OpenConfig(config, options.log); };
  if (config.empty() && options.open_config().ok()) {
    std::fprintf(stderr, "vantage-replay: configuration from the log's LOG_HEADER\n");
  }
  Progress progress;
  const Result<ReplaySummary> summary = RunReplay(
      options, [&](double share, int64_t num_events) { progress.Show(share, num_events); });
  progress.Clear();
  if (!summary) {
    std::fprintf(stderr, "vantage-replay: %s\n", summary.error().message.c_str());
    return 2;
  }
  PrintSummary(*summary, progress.seconds());
  return 0;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
