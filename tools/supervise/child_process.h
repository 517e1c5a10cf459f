#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A program that runs beside this one, with its output in a pipe.
struct ChildProcess {
  pid_t pid = -1;
  int output = -1;  ///< read end of its standard output and error
};

/// Starts a program in a process group of its own, so that a Ctrl-C does not reach it, with no
/// signal blocked. It is asked to end (SIGTERM) when this process dies. Errors: the system refuses.
Result<ChildProcess> StartChild(const std::vector<std::string>& words);

/// Waits for its end. @return its exit code; 128 + the signal that ended it
int WaitForChild(const ChildProcess& child);

struct ChildOutput {
  int exit_code = 0;
  std::string text;  ///< standard output and error
};

/// Runs a program to its end. What it leaves behind may go on; its output counts until then.
Result<ChildOutput> RunChild(const std::vector<std::string>& words);

}  // namespace vantage
