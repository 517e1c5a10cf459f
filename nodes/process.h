#pragma once

#include <functional>
#include <memory>
#include <string>

#include "bus/bus.h"
#include "bus/live_bus.h"
#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/node.h"

namespace vantage {

/// What the command line said, beside the config file.
struct ProcessOptions {
  std::string name;    ///< Of the process, unique on a bus; --name.
  bool fresh = false;  ///< --fresh: forget a saved state.
};

using NodeFactory = std::function<Result<std::unique_ptr<Node>>(
    Bus& bus, ConfigReader& config, const ProcessOptions& options)>;

/// What --list of a driver prints.
using DeviceLister = std::function<Result<std::string>()>;

/// main() of a live process: reads --config, --lcm-url, --name, --fresh; opens the live bus;
/// refuses a second process of the same name; makes the node; runs until SIGINT or SIGTERM. A
/// driver that has a lister has --list instead of all that.
/// Returns the exit code: 0 after a signal, 2 after an error, which is printed as one sentence.
int RunProcess(int argc,
               char** argv,
               const std::string& default_name,
               const std::string& description,
               const NodeFactory& make_node,
               const DeviceLister& list = nullptr);

/// Reads [bus]: URL and receive buffers. The name is the caller's to fill in.
LiveBus::Options ReadBusOptions(ConfigReader& config);

/// Takes every top-level table that some process reads as known, so that one file serves all of
/// them and a misspelt table is still an error. A process calls it after it has read its own.
void IgnoreTablesOfOthers(ConfigReader& config);

}  // namespace vantage
