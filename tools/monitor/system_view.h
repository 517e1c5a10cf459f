#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/camera/camera_device.h"

namespace vantage {

/// What vantage-doctor looks at of the machine; a test gives it another one.
struct SystemView {
  struct CommandOutput {
    bool started = false;  ///< the program is there
    int exit_code = -1;
    std::string text;  ///< standard output and error, cut off at 64 KiB
  };
  struct ClockState {
    bool is_known = false;
    bool is_synchronized = false;
    int64_t utime = 0;  ///< us since the epoch, now
  };
  /// One second of short sleeps.
  struct Stalls {
    double longest = 0.0;     ///< s, by which the latest of them ended late
    double clock_step = 0.0;  ///< s, by which the wall clock left the steady one meanwhile
  };

  std::filesystem::path root = "/";  ///< of the files in /proc, /sys, /etc, /dev, /usr
  std::string user;                  ///< who would be added to a group
  bool is_root = false;

  std::function<CommandOutput(const std::vector<std::string>&)> run;
  std::function<std::string(const std::string&)> environment;   ///< empty: it is not set
  std::function<unsigned(const std::string&)> interface_flags;  ///< IFF_UP, ...; 0: no such one
  /// Opens for reading and writing by this user: 0, or why not as an errno.
  std::function<int(const std::filesystem::path&)> access;
  std::function<std::string(const std::filesystem::path&)> group_of;  ///< a file's
  std::function<std::optional<uint64_t>(int)> limit;  ///< of RLIMIT_...; nothing: none
  std::function<std::optional<double>(const std::filesystem::path&)> free_bytes;  ///< of its disk
  std::function<ClockState()> clock;
  std::function<Stalls()> measure_stalls;
  std::function<Result<std::vector<DeviceListing>>()> openni2_devices;

  static SystemView Real();

  /// At most the first 1 MiB of a file below the root; nothing when it can't be read.
  [[nodiscard]] std::optional<std::string> Read(const std::string& path) const;
  /// The first line of it, or "".
  [[nodiscard]] std::string ReadLine(const std::string& path) const;
  /// Names in a folder below the root, sorted; empty when it can't be read.
  [[nodiscard]] std::vector<std::string> List(const std::string& path) const;
  /// A command for the administrator: with sudo unless this user is it.
  [[nodiscard]] std::string AsRoot(const std::string& command) const;
  /// Sets a key of sysctl now and after the next start.
  [[nodiscard]] std::string SetSysctl(const std::string& key, int64_t value) const;
};

}  // namespace vantage
