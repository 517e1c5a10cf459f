// vantage-replay: reruns estimators and fusion on a log in one process, without loss and as fast
// as they compute.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/log_bus.h"
#include "common/format.h"
#include "nodes/command_line.h"
#include "nodes/config_reader.h"
#include "nodes/estimator_node.h"
#include "nodes/extrinsics_node.h"
#include "nodes/fusion_node.h"
#include "nodes/ppf_config.h"
#include "nodes/shot_config.h"
#include "tools/support/log_config.h"
#include "tools/support/object_table.h"
#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {
namespace {

// What the nodes here publish anew, and ARM_STATUS: it answers the recorded NEXT_VIEW, not the one
// that is computed here.
constexpr const char* kRecomputed =
    "DETECTIONS_.*|OBJECTS|ORIENTATION_HISTOGRAM|NEXT_VIEW|ARM_STATUS|PROCESS_STATUS";

// What vantage-extrinsics publishes.
constexpr const char* kRecomputedExtrinsics =
    "|CAMERA_.*_TO_WORLD|NEXT_HAND_POSE|HANDEYE_RESULT|HANDEYE_CHECK";

struct Arguments {
  std::string log;
  std::string config;
  std::string output;
  bool with_inputs = false;
  bool with_extrinsics = false;
  std::vector<std::string> estimators = {"ppf"};
};

/// The nodes of one rerun. They outlive the bus's last step.
struct Nodes {
  std::unique_ptr<Node> extrinsics;
  std::vector<std::unique_ptr<Node>> estimators;
  std::unique_ptr<Node> fusion;
};

Result<std::unique_ptr<Node>> MakeEstimator(Bus& bus,
                                            const Arguments& arguments,
                                            const std::string& name) {
  // A reader each: every process takes its own tables from the file.
  Result<ConfigReader> config = OpenConfig(arguments.config, arguments.log);
  if (!config) return config.error();
  ProcessOptions options;
  options.name = name;
  return name == "ppf" ? MakePpfNode(bus, *config, options) : MakeShotNode(bus, *config, options);
}

/// The seed of the first estimator. Errors: the config.
Result<uint64_t> ReadSeed(ConfigReader& config, const std::string& estimator) {
  if (estimator == "ppf") {
    const Result<PpfConfig> ppf = ReadPpfConfig(config);
    if (!ppf) return ppf.error();
    return ppf->seed;
  }
  const Result<ShotConfig> shot = ReadShotConfig(config);
  if (!shot) return shot.error();
  return shot->seed;
}

Result<Nodes> MakeNodes(Bus& bus, const Arguments& arguments) {
  Nodes nodes;
  if (arguments.with_extrinsics) {
    Result<ConfigReader> own = OpenConfig(arguments.config, arguments.log);
    if (!own) return own.error();
    Result<std::unique_ptr<Node>> extrinsics = MakeExtrinsicsNode(bus, *own, {});
    if (!extrinsics) return extrinsics.error();
    nodes.extrinsics = std::move(extrinsics).value();
  }
  for (const std::string& name : arguments.estimators) {
    Result<std::unique_ptr<Node>> estimator = MakeEstimator(bus, arguments, name);
    if (!estimator) return estimator.error();
    nodes.estimators.push_back(std::move(estimator).value());
  }

  Result<ConfigReader> config = OpenConfig(arguments.config, arguments.log);
  if (!config) return config.error();
  Result<FusionConfig> fusion_config = ReadFusionConfig(*config);
  if (!fusion_config) return fusion_config.error();
  fusion_config->state_file.clear();  // A rerun starts from nothing and leaves nothing.
  Result<std::unique_ptr<Node>> fusion = MakeFusionNode(bus, *fusion_config, false);
  if (!fusion) return fusion.error();
  nodes.fusion = std::move(fusion).value();
  return nodes;
}

class Progress {
 public:
  void Show(const LogBus& bus) {
    if (isatty(STDERR_FILENO) == 0) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(200)) return;
    last_ = now;
    std::fprintf(stderr,
                 "\r%3.0f %%  %jd events",
                 100.0 * bus.input().progress(),
                 intmax_t{bus.counters().num_events});
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

void PrintSummary(const LogBus& bus,
                  const object_estimates_v3_t& objects,
                  double seconds,
                  double span) {
  std::printf("%s", ObjectTable(objects).c_str());
  std::printf("%jd events of %.1f s in %.1f s (%.1f times as fast as it was recorded)\n",
              intmax_t{bus.counters().num_events},
              span,
              seconds,
              seconds > 0.0 ? span / seconds : 0.0);
  for (const auto& [channel, count] : bus.counters().decode_errors) {
    std::printf("%s: %jd messages could not be decoded\n", channel.c_str(), intmax_t{count});
  }
  if (bus.input().damage().any()) {
    std::printf("damage: %s\n", bus.input().damage().Describe().c_str());
  }
}

Result<void> Replay(const Arguments& arguments) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(arguments.log);
  if (!reader) return reader.error();
  Result<ConfigReader> config = OpenConfig(arguments.config, arguments.log);
  if (!config) return config.error();
  if (arguments.config.empty()) {
    std::fprintf(stderr, "vantage-replay: configuration from the log's LOG_HEADER\n");
  }
  const Result<uint64_t> seed = ReadSeed(*config, arguments.estimators.front());
  if (!seed) return seed.error();

  std::unique_ptr<EventLogWriter> writer;
  if (!arguments.output.empty()) {
    Result<std::unique_ptr<EventLogWriter>> created = EventLogWriter::Create(arguments.output);
    if (!created) return created.error();
    writer = std::move(created).value();
  }
  LogBus::Options options;
  options.suppress = kRecomputed;
  if (arguments.with_extrinsics) options.suppress += kRecomputedExtrinsics;
  options.copy_inputs = arguments.with_inputs;
  options.header.version = VANTAGE_VERSION;
  options.header.config_text = config->text();
  options.header.seed = static_cast<int64_t>(*seed);
  Result<std::unique_ptr<LogBus>> bus =
      LogBus::Create(options, std::move(reader).value(), writer.get());
  if (!bus) return bus.error();
  const Result<Nodes> nodes = MakeNodes(**bus, arguments);
  if (!nodes) return nodes.error();
  object_estimates_v3_t objects{};
  if (Result<void> subscribed = (*bus)->Subscribe<object_estimates_v3_t>(
          "OBJECTS",
          {},
          [&objects](const Envelope&, const object_estimates_v3_t& message) { objects = message; });
      !subscribed) {
    return subscribed;
  }

  Progress progress;
  const int64_t start = (*bus)->NowUtime();
  while (true) {
    const Result<bool> more = (*bus)->Step();
    if (!more) return more.error();
    if (!*more) break;
    progress.Show(**bus);
  }
  progress.Clear();
  if (writer) {
    if (Result<void> closed = writer->Close(); !closed) return closed;
  }
  PrintSummary(
      **bus, objects, progress.seconds(), 1e-6 * static_cast<double>((*bus)->NowUtime() - start));
  return {};
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("Reruns estimators and fusion on a log, in one process and without loss",
               "vantage-replay");
  app.add_option("log", arguments.log, "LCM event log")->required();
  app.add_option("--config,-c",
                 arguments.config,
                 "TOML file of the set-up; default: the one in the log's LOG_HEADER");
  app.add_option("--output,-o", arguments.output, "log to write what is recomputed to");
  app.add_option("--estimator", arguments.estimators, "ppf, shot, or both; default: ppf")
      ->check(CLI::IsMember({"ppf", "shot"}));
  app.add_flag("--with-inputs", arguments.with_inputs, "copy what is read into the output too");
  app.add_flag("--extrinsics",
               arguments.with_extrinsics,
               "camera poses anew too, from HAND_TO_BASE by the calibration of [extrinsics]");
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  if (const vantage::Result<void> done = vantage::Replay(arguments); !done) {
    std::fprintf(stderr, "vantage-replay: %s\n", done.error().message.c_str());
    return 2;
  }
  return 0;
}
