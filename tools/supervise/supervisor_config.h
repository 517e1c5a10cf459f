#pragma once

#include <string>

#include "common/result.h"
#include "tools/supervise/process_plan.h"
#include "tools/supervise/run_folder.h"

namespace vantage {

/// A supervisord.conf that runs the plan: starts in the order of the stages, stops backwards, one
/// process after the other; a socket for its owner alone and no TCP; logs that are rotated.
/// Errors: setpriv, env or nice is not installed.
Result<std::string> SupervisorConfig(const ProcessPlan& plan, const RunFolder& run);

/// Words as one line that the supervisor splits into the same words (Python's shlex, after it has
/// cut off comments and replaced %(name)s).
std::string SupervisorCommand(const std::vector<std::string>& words);

}  // namespace vantage
