#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "bus/live_bus.h"
#include "common/result.h"
#include "tools/log/recording.h"

namespace vantage {

/// `vantage-log record`: a log of what is on the bus.
class RecordCommand {
 public:
  explicit RecordCommand(CLI::App* app);
  [[nodiscard]] bool IsChosen() const { return command_->parsed(); }
  /// Until SIGINT or SIGTERM. @return the exit code: 1 when it ended by itself, because the disk
  /// took no more.
  [[nodiscard]] Result<int> Run() const;

 private:
  [[nodiscard]] Result<RecordingOptions> ReadOptions() const;
  [[nodiscard]] Result<LiveBus::Options> ReadBus() const;

  CLI::App* command_;
  std::string config_;
  std::string file_;
  std::string folder_;
  std::string channels_ = ".*";
  std::string exclude_;
  std::string url_;
  double split_mb_ = 0.0;
  double split_minutes_ = 0.0;
  double min_free_mb_ = 256.0;
  bool force_ = false;
};

}  // namespace vantage
