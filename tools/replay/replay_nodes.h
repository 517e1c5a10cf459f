#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bus/log_bus.h"
#include "common/result.h"
#include "nodes/estimator_node.h"
#include "nodes/node.h"
#include "tools/replay/as_received.h"
#include "tools/replay/replay_options.h"

namespace vantage {

/// An estimator of a rerun.
struct ReplayEstimator {
  std::string name;  ///< "ppf"
  EstimatorConfig config;
  EstimateFunction estimate;
};

/// The nodes on one LogBus. They outlive its last step.
struct ReplayNodes {
  std::unique_ptr<AsReceived> as_received;  ///< null where every image is delivered
  std::unique_ptr<Node> extrinsics;
  std::vector<std::unique_ptr<EstimatorNode>> estimators;
  std::unique_ptr<Node> fusion;
};

/// The nodes of a rerun. Errors: the configuration, or what it names.
Result<ReplayNodes> MakeReplayNodes(LogBus* bus,
                                    const ReplayOptions& options,
                                    const std::vector<ReplayEstimator>& estimators);

/// Those that have a part in which images are estimated: no fusion, and of the extrinsics the
/// camera's poses alone.
Result<ReplayNodes> MakeScoutNodes(LogBus* bus,
                                   const ReplayOptions& options,
                                   const std::vector<ReplayEstimator>& estimators);

}  // namespace vantage
