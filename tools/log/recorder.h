#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>

#include "bus/live_bus.h"
#include "common/result.h"
#include "tools/log/loss_counter.h"
#include "tools/log/recording.h"

namespace vantage {

/// Takes what comes over a live bus into a recording. The bus's own thread receives, into a queue
/// of kQueueBytes; the thread that calls Run() writes. So a disk that stalls costs nothing before
/// the queue is full.
class Recorder {
 public:
  /// @param bus outlives it.
  explicit Recorder(LiveBus* bus) : bus_(bus) {}

  /// @param channels a regular expression of whole names; @param exclude the same, of those not to
  /// record; empty: none. Errors: no regular expression.
  Result<void> Listen(const std::string& channels, const std::string& exclude);

  /// Until a stop, then to the end of what had arrived. Tells on stderr, at most once in five
  /// seconds, and in the process's status what is lost. Errors: the recording can't go on; what is
  /// in it stays.
  Result<void> Run(Recording* recording, const std::stop_token& stop);

  [[nodiscard]] const LossCounter& losses() const { return losses_; }

  static constexpr size_t kQueueBytes = size_t{256} << 20U;

 private:
  using Clock = std::chrono::steady_clock;

  void Take(const Envelope& envelope, std::span<const std::byte> bytes);
  void Poll(Clock::time_point now);
  void TellLosses(Clock::time_point now);
  void Drain();

  LiveBus* bus_;
  Recording* recording_ = nullptr;  // While Run() runs.
  LossCounter losses_;
  std::optional<Error> error_;
  int64_t taken_utime_ = 0;  // us since the epoch at which the last one arrived.
  int64_t told_ = 0;         // Losses.
  std::optional<Clock::time_point> told_at_;
  Clock::time_point next_poll_{};
  Clock::time_point next_sync_{};
};

}  // namespace vantage
