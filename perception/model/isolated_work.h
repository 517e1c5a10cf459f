#pragma once

#include <functional>
#include <string>

#include "common/result.h"

namespace vantage {

/// Runs `work` in a child process and gives back the bytes that it returned. For libraries that may
/// abort, crash or never end on what is in a file: only the child then dies.
/// Errors: the system refuses, the child died by a signal, or worked longer than `seconds`.
Result<std::string> RunIsolated(const std::function<std::string()>& work, unsigned int seconds);

}  // namespace vantage
