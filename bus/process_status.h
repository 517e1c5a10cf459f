#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "vantage/process_status_t.hpp"

namespace vantage {

/// The counters behind PROCESS_STATUS. Any thread may call anything.
class ProcessStatus {
 public:
  using Clock = std::chrono::steady_clock;

  /// Lists a channel that nothing has come on yet.
  void AddChannel(const std::string& channel);
  void RecordReceived(const std::string& channel, Clock::time_point now);
  void RecordLost(const std::string& channel, int64_t count);
  void RecordOverwritten(const std::string& channel);
  /// @return true when this error should be told: at most one a channel in five seconds.
  bool RecordDecodeError(const std::string& channel, Clock::time_point now);
  void RecordStage(const std::string& stage, double seconds);
  void SetState(const std::string& state);

  /// Writes state, channels and stages. Rates are over the time since the last call that was at
  /// least half a second after the one before.
  void Fill(Clock::time_point now, process_status_t* message);

  static constexpr size_t kMaxChannels = 500;  ///< names come from outside; the rest is one entry
  static constexpr size_t kWindow = 256;       ///< runs of a stage that its percentiles look at

 private:
  struct Channel {
    channel_status_t status{};
    Clock::time_point last{};
    int64_t received_at_window = 0;
    Clock::time_point last_report{};
    bool reported = false;
  };
  struct Stage {
    std::array<double, kWindow> latest{};  // s, a ring
    int64_t num_runs = 0;
    double longest = 0.0;
  };

  Channel& Find(const std::string& channel);
  static stage_status_t Summarize(const std::string& name, const Stage& stage);

  std::mutex mutex_;
  std::string state_ = "ok";
  std::map<std::string, Channel> channels_;
  std::map<std::string, Stage> stages_;
  Clock::time_point window_start_ = Clock::now();
};

}  // namespace vantage
