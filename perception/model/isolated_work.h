#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "common/result.h"

namespace vantage {

/// What the child process may take before it is ended.
struct IsolationLimits {
  unsigned int seconds = 300;
  /// bytes of memory beyond what this process has; more is refused as by a full machine. Without
  /// effect in builds with a sanitizer, which take address space by the terabyte.
  size_t memory = size_t{1} << 30U;
};

/// Runs `work` in a child process and gives back the bytes that it returned. For libraries that may
/// abort, crash, never end or take all memory on what is in a file: only the child then dies.
/// Errors: the system refuses, the child died by a signal, or worked longer than it may.
Result<std::string> RunIsolated(const std::function<std::string()>& work,
                                const IsolationLimits& limits);

}  // namespace vantage
