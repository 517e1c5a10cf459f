#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace vantage {

/// The real vantage-v4l2, found beside this program. Killed, if it still runs, with this object.
class DriverProcess {
 public:
  /// Starts it on a config file of this text.
  explicit DriverProcess(const std::string& config);
  ~DriverProcess();
  DriverProcess(const DriverProcess&) = delete;
  DriverProcess& operator=(const DriverProcess&) = delete;

  [[nodiscard]] bool IsRunning();
  /// Asks it to end and waits. @return its exit code; -1 when it ended otherwise.
  int Stop();
  /// What it printed.
  [[nodiscard]] std::string Output() const;

 private:
  std::string log_file_;
  pid_t pid_ = -1;
};

}  // namespace vantage
