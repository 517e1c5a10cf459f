#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tools/supervise/process_plan.h"
#include "tools/supervise/run_folder.h"

namespace vantage {

/// Debian's supervisor at work for one set-up. Every function tells on stdout what it does and
/// returns the exit code: 0, or 1 when a process of the set-up has failed for good.
class Supervisor {
 public:
  /// Errors: supervisor is not installed.
  static Result<Supervisor> Find(const RunFolder& run);

  /// Starts all and shows what happens to them until SIGINT, SIGTERM or SIGHUP, or until one has
  /// failed for good; then stops all. Errors: the set-up is up already; folders; no signal
  /// handling.
  [[nodiscard]] Result<int> RunInForeground(const ProcessPlan& plan) const;
  /// Starts all and returns once they have stayed up; where one has failed for good, stops all.
  /// Errors: as above.
  [[nodiscard]] Result<int> RunInBackground(const ProcessPlan& plan) const;
  /// What state each process is in, as supervisorctl prints it. Errors: the set-up is not up.
  [[nodiscard]] Result<int> PrintStatus() const;
  /// Ends one process until it is started again, or all and the supervisor (`name` empty), in
  /// order. Errors: the set-up is not up; no such process.
  [[nodiscard]] Result<int> Stop(const std::string& name) const;
  /// Ends and starts one process; or all (`name` empty), as the configuration now is.
  /// Errors: as above.
  [[nodiscard]] Result<int> Restart(const ProcessPlan& plan, const std::string& name) const;

 private:
  Supervisor(RunFolder run, std::string daemon, std::string control)
      : run_(std::move(run)), daemon_(std::move(daemon)), control_(std::move(control)) {}

  [[nodiscard]] Result<void> Prepare(const ProcessPlan& plan) const;
  [[nodiscard]] Result<void> CheckUp() const;
  [[nodiscard]] Result<std::string> Control(const std::vector<std::string>& words) const;
  [[nodiscard]] Result<int> WaitUntilSettled() const;
  void TellFailure(const std::string& name) const;

  RunFolder run_;
  std::string daemon_;   // supervisord
  std::string control_;  // supervisorctl
};

}  // namespace vantage
