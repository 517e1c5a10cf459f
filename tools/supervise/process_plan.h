#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/up_config.h"

namespace vantage {

/// The order of starting, and backwards of stopping: who asks for something ends before who gives
/// it.
enum class UpStage { kRecorder, kRobot, kCamera, kExtrinsics, kEstimator, kFusion };

/// One process that a set-up consists of.
struct PlannedProcess {
  std::string name;  ///< on the bus
  UpStage stage = UpStage::kRobot;
  std::vector<std::string> command;  ///< program first, absolute
  std::vector<std::pair<std::string, std::string>> environment;
  int nice = 0;
};

/// All that a configuration implies.
struct ProcessPlan {
  std::filesystem::path config;  ///< absolute
  UpConfig up;
  std::vector<PlannedProcess> processes;  ///< in the order of starting
};

/// Which processes the file asks for: [sim] for vantage-sim-arm, each [camera.<NAME>] for its
/// driver, [extrinsics], [ppf], [shot] and [fusion] for the processes of these names, [up] record
/// for a recorder, [[up.process]] for others. Each process's own reader reads the file first, so
/// that what it would refuse is refused before anything starts.
/// @param programs folder of our programs
/// Errors: what a process refuses in the file; a program that is not there; nothing to start;
/// control characters in a path or argument.
Result<ProcessPlan> MakeProcessPlan(const std::filesystem::path& config,
                                    const std::filesystem::path& programs);

}  // namespace vantage
