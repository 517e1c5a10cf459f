#include "tools/replay/replay_run.h"

#include <memory>
#include <utility>

#include "nodes/estimator_node.h"
#include "nodes/extrinsics_node.h"
#include "nodes/fusion_node.h"
#include "nodes/ppf_config.h"
#include "nodes/shot_config.h"

namespace vantage {
namespace {

// What the nodes here publish anew, and ARM_STATUS: it answers the recorded NEXT_VIEW, not the one
// that is computed here.
constexpr const char* kRecomputed =
    "DETECTIONS_.*|OBJECTS|ORIENTATION_HISTOGRAM|NEXT_VIEW|ARM_STATUS|PROCESS_STATUS";

// What vantage-extrinsics publishes.
constexpr const char* kRecomputedExtrinsics =
    "|CAMERA_.*_TO_WORLD|NEXT_HAND_POSE|HANDEYE_RESULT|HANDEYE_CHECK";

/// The nodes of one rerun. They outlive the bus's last step.
struct Nodes {
  std::unique_ptr<Node> extrinsics;
  std::vector<std::unique_ptr<Node>> estimators;
  std::unique_ptr<Node> fusion;
};

Result<std::unique_ptr<Node>> MakeEstimator(Bus& bus,
                                            const ReplayOptions& options,
                                            const std::string& name) {
  // A reader each: every process takes its own tables from the file.
  Result<ConfigReader> config = options.open_config();
  if (!config) return config.error();
  ProcessOptions process;
  process.name = name;
  return name == "ppf" ? MakePpfNode(bus, *config, process) : MakeShotNode(bus, *config, process);
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

Result<Nodes> MakeNodes(Bus& bus, const ReplayOptions& options) {
  Nodes nodes;
  if (options.with_extrinsics) {
    Result<ConfigReader> own = options.open_config();
    if (!own) return own.error();
    Result<std::unique_ptr<Node>> extrinsics = MakeExtrinsicsNode(bus, *own, {});
    if (!extrinsics) return extrinsics.error();
    nodes.extrinsics = std::move(extrinsics).value();
  }
  for (const std::string& name : options.estimators) {
    Result<std::unique_ptr<Node>> estimator = MakeEstimator(bus, options, name);
    if (!estimator) return estimator.error();
    nodes.estimators.push_back(std::move(estimator).value());
  }

  Result<ConfigReader> config = options.open_config();
  if (!config) return config.error();
  Result<FusionConfig> fusion_config = ReadFusionConfig(*config);
  if (!fusion_config) return fusion_config.error();
  fusion_config->state_file.clear();  // A rerun starts from nothing and leaves nothing.
  Result<std::unique_ptr<Node>> fusion = MakeFusionNode(bus, *fusion_config, false);
  if (!fusion) return fusion.error();
  nodes.fusion = std::move(fusion).value();
  return nodes;
}

}  // namespace

Result<ReplaySummary> RunReplay(const ReplayOptions& options, const ReplayProgress& progress) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(options.log);
  if (!reader) return reader.error();
  Result<ConfigReader> config = options.open_config();
  if (!config) return config.error();
  const Result<uint64_t> seed = ReadSeed(*config, options.estimators.front());
  if (!seed) return seed.error();

  std::unique_ptr<EventLogWriter> writer;
  if (!options.output.empty()) {
    Result<std::unique_ptr<EventLogWriter>> created = EventLogWriter::Create(options.output);
    if (!created) return created.error();
    writer = std::move(created).value();
  }
  LogBus::Options bus_options;
  bus_options.suppress = kRecomputed;
  if (options.with_extrinsics) bus_options.suppress += kRecomputedExtrinsics;
  bus_options.copy_inputs = options.with_inputs;
  bus_options.header.version = VANTAGE_VERSION;
  bus_options.header.config_text = config->text();
  bus_options.header.seed = static_cast<int64_t>(*seed);
  Result<std::unique_ptr<LogBus>> bus =
      LogBus::Create(bus_options, std::move(reader).value(), writer.get());
  if (!bus) return bus.error();
  const Result<Nodes> nodes = MakeNodes(**bus, options);
  if (!nodes) return nodes.error();
  ReplaySummary summary;
  if (Result<void> subscribed = (*bus)->Subscribe<object_estimates_v3_t>(
          "OBJECTS",
          {},
          [&summary](const Envelope&, const object_estimates_v3_t& message) {
            summary.objects = message;
          });
      !subscribed) {
    return subscribed.error();
  }

  const int64_t start = (*bus)->NowUtime();
  while (true) {
    const Result<bool> more = (*bus)->Step();
    if (!more) return more.error();
    if (!*more) break;
    progress((*bus)->input().progress(), (*bus)->counters().num_events);
  }
  if (writer) {
    if (Result<void> closed = writer->Close(); !closed) return closed.error();
  }
  summary.counters = (*bus)->counters();
  summary.damage = (*bus)->input().damage();
  summary.span = 1e-6 * static_cast<double>((*bus)->NowUtime() - start);
  return summary;
}

}  // namespace vantage
