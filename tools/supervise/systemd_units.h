#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/supervise/process_plan.h"
#include "tools/supervise/run_folder.h"

namespace vantage {

/// Unit files by name: a service for each process and a target, vantage-ID.target, that is the
/// set-up. What it starts ends in backward order when the target is stopped; output goes to the
/// journal.
std::map<std::string, std::string> SystemdUnits(const ProcessPlan& plan, const RunFolder& run);

/// Words as an ExecStart= line of the same words.
std::string SystemdCommand(const std::vector<std::string>& words);

}  // namespace vantage
