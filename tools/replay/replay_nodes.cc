#include "tools/replay/replay_nodes.h"

#include <utility>

#include "nodes/extrinsics_node.h"
#include "nodes/fusion_node.h"
#include "nodes/handeye_file.h"

namespace vantage {
namespace {

constexpr size_t kHeldBytes = size_t{256} << 20U;  // Of images that wait for their detections.

Result<std::unique_ptr<Node>> MakeExtrinsics(LogBus* bus, const ReplayOptions& options) {
  Result<ConfigReader> config = options.open_config();
  if (!config) return config.error();
  return MakeExtrinsicsNode(*bus, *config, {});
}

// Looks neither for the target nor at detections.
Result<std::unique_ptr<Node>> MakeScoutExtrinsics(LogBus* bus, const ReplayOptions& options) {
  Result<ConfigReader> config = options.open_config();
  if (!config) return config.error();
  Result<ExtrinsicsConfig> read = ReadExtrinsicsConfig(*config);
  if (!read) return read.error();
  const Result<HandEyeFile> calibration = ReadHandEyeFile(read->calibration);
  if (!calibration) return calibration.error();
  read->target.reset();
  read->detections.clear();
  Result<std::unique_ptr<ExtrinsicsNode>> node = ExtrinsicsNode::Create(*bus, *read, *calibration);
  if (!node) return node.error();
  return std::unique_ptr<Node>(std::move(node).value());
}

Result<void> AddEstimators(LogBus* bus,
                           const ReplayOptions& options,
                           const std::vector<ReplayEstimator>& estimators,
                           ReplayNodes* nodes) {
  if (options.as_received) nodes->as_received = std::make_unique<AsReceived>(bus, kHeldBytes);
  for (const ReplayEstimator& each : estimators) {
    LogBus::Port* port = nullptr;
    if (options.as_received) {
      Result<LogBus::Port*> added = bus->AddPort("CAMERA_" + each.config.camera);
      if (!added) return added.error();
      port = *added;
    }
    Bus& own = port != nullptr ? static_cast<Bus&>(*port) : *bus;
    Result<std::unique_ptr<EstimatorNode>> node =
        EstimatorNode::Create(own, each.config, each.name, each.estimate);
    if (!node) return node.error();
    if (port != nullptr) {
      nodes->as_received->Add(each.name, each.config.camera, port, node->get());
    }
    nodes->estimators.push_back(std::move(node).value());
  }
  return {};
}

}  // namespace

Result<ReplayNodes> MakeReplayNodes(LogBus* bus,
                                    const ReplayOptions& options,
                                    const std::vector<ReplayEstimator>& estimators) {
  ReplayNodes nodes;
  if (options.with_extrinsics) {
    Result<std::unique_ptr<Node>> extrinsics = MakeExtrinsics(bus, options);
    if (!extrinsics) return extrinsics.error();
    nodes.extrinsics = std::move(extrinsics).value();
  }
  if (Result<void> added = AddEstimators(bus, options, estimators, &nodes); !added) {
    return added.error();
  }
  Result<ConfigReader> config = options.open_config();
  if (!config) return config.error();
  Result<FusionConfig> fusion_config = ReadFusionConfig(*config);
  if (!fusion_config) return fusion_config.error();
  fusion_config->state_file.clear();  // A rerun starts from nothing and leaves nothing.
  Result<std::unique_ptr<Node>> fusion = MakeFusionNode(*bus, *fusion_config, false);
  if (!fusion) return fusion.error();
  nodes.fusion = std::move(fusion).value();
  return nodes;
}

Result<ReplayNodes> MakeScoutNodes(LogBus* bus,
                                   const ReplayOptions& options,
                                   const std::vector<ReplayEstimator>& estimators) {
  ReplayNodes nodes;
  if (options.with_extrinsics) {
    Result<std::unique_ptr<Node>> extrinsics = MakeScoutExtrinsics(bus, options);
    if (!extrinsics) return extrinsics.error();
    nodes.extrinsics = std::move(extrinsics).value();
  }
  if (Result<void> added = AddEstimators(bus, options, estimators, &nodes); !added) {
    return added.error();
  }
  return nodes;
}

}  // namespace vantage
