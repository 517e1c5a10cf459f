// Reruns a log with one thread and with two, in turn: how many times as fast as it was recorded,
// with the loading of configuration and models, and whether the outputs are the same, byte for
// byte. Writes its figures as Google Benchmark does, for vantage-bench-table.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/format.h"
#include "common/statistics.h"
#include "nodes/command_line.h"
#include "perception/model/file_bytes.h"
#include "tests/bench/bench_rows.h"
#include "tools/replay/replay_run.h"

namespace vantage {
namespace {

constexpr int kRuns = 5;
constexpr size_t kMostOutput = size_t{1} << 30U;  // bytes

struct Arguments {
  std::string log;
  std::string config;
  std::string output;
};

/// One way to rerun the log, and what came of it.
struct Way {
  std::string name;
  int threads = 1;
  bool as_received = false;
  std::vector<double> speeds = {};  // times as fast as recorded
  double span = 0.0;                // s
  bool is_same = true;              // Every output as the first of its kind.
};

Result<void> Rerun(const Arguments& arguments, std::map<bool, std::string>* first, Way* way) {
  ReplayOptions options;
  options.log = arguments.log;
  options.output = arguments.output + ".lcm";
  options.threads = way->threads;
  options.as_received = way->as_received;
  options.open_config = [&] { return ConfigReader::Open(arguments.config); };
  const auto start = std::chrono::steady_clock::now();
  const Result<ReplaySummary> summary = RunReplay(options, [](double, int64_t) {});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!summary) return summary.error();
  const Result<std::string> bytes = ReadFileBytes(options.output, kMostOutput);
  std::filesystem::remove(options.output);
  if (!bytes) return bytes.error();
  way->span = summary->span;
  way->speeds.push_back(summary->span / seconds);
  const auto [entry, is_first] = first->try_emplace(way->as_received, *bytes);
  way->is_same = way->is_same && entry->second == *bytes;
  return {};
}

Result<void> Run(const Arguments& arguments) {
  std::vector<Way> ways = {{.name = "1_thread"},
                           {.name = "2_threads", .threads = 2},
                           {.name = "as_received", .threads = 2, .as_received = true}};
  std::map<bool, std::string> first;  // Output of each kind.
  for (int run = 0; run < kRuns; ++run) {
    for (Way& way : ways) {
      if (Result<void> done = Rerun(arguments, &first, &way); !done) return done;
    }
  }
  nlohmann::json rows = nlohmann::json::array();
  for (const Way& way : ways) {
    nlohmann::json speed =
        BenchRow("rerun/" + way.name + "/times_as_fast", Median(way.speeds), "x");
    speed["log_s"] = way.span;
    speed["slowest"] = Quantile(way.speeds, 0.0);
    speed["of_one_thread"] = Median(way.speeds) / Median(ways.front().speeds);
    rows.push_back(speed);
    rows.push_back(BenchRow("rerun/" + way.name + "/equal", way.is_same ? 1.0 : 0.0, ""));
  }
  return WriteBenchRows(rows, arguments.output);
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Measures reruns of a log.", "replay_bench");
  app.add_option("log", arguments.log, "LCM event log")->required();
  app.add_option("--config", arguments.config, "TOML file of the set-up")->required();
  app.add_option("--output", arguments.output, "JSON file to write")->required();
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  const Result<void> done = Run(arguments);
  if (done) return 0;
  std::fprintf(stderr, "replay_bench: %s\n", done.error().message.c_str());
  return 2;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Main(argc, argv); }
