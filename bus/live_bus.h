#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "bus/bus.h"
#include "vantage/process_status_t.hpp"

namespace vantage {

/// The wire: LCM. A thread of its own copies what arrives into mailboxes, another one publishes
/// PROCESS_STATUS every second however long a handler computes; handlers run on the thread that
/// calls Dispatch() or Run(), which is the one that made the bus. Any thread may publish.
class LiveBus : public Bus {
 public:
  struct Options {
    std::string url{};      ///< LCM's; empty: LCM_DEFAULT_URL, or udpm://239.255.76.67:7667?ttl=0
    std::string name{};     ///< of the process, in PROCESS_STATUS
    std::string version{};  ///< in PROCESS_STATUS
    std::string config_hash{};                  ///< in PROCESS_STATUS
    int receive_buffer_bytes = 4 << 20;         ///< asked of the kernel for incoming messages
    int min_receive_buffer_bytes = 128 * 1024;  ///< less than this granted is an error

    Result<void> Validate() const;
  };

  /// Errors: the URL is malformed, there is no multicast route, LCM refuses, or the kernel grants
  /// too small a receive buffer; each names the command that mends it.
  static Result<std::unique_ptr<LiveBus>> Create(const Options& options);
  ~LiveBus() override;
  LiveBus(const LiveBus&) = delete;
  LiveBus& operator=(const LiveBus&) = delete;

  /// Hands over the messages of any type on a channel (as in Subscribe()) as they came, unchecked:
  /// for those who record or count them.
  using TapHandler = std::function<void(const Envelope&, std::span<const std::byte>)>;
  Result<void> Tap(const std::string& channel, SubscribeOptions options, TapHandler handler);

  /// Hands over the message that waits longest, waiting for one up to `timeout`.
  /// @return false when none came.
  bool Dispatch(std::chrono::milliseconds timeout);
  /// Hands over messages until a stop is asked for, and calls `poll` at least every
  /// `poll_interval` between them.
  void Run(const std::stop_token& stop,
           const std::function<void()>& poll = {},
           std::chrono::milliseconds poll_interval = std::chrono::milliseconds(100));

  void RecordStage(const std::string& stage, double seconds) override;
  void RecordLost(const std::string& channel, int64_t count) override;
  void SetState(const std::string& state) override;
  [[nodiscard]] int64_t NowUtime() const override;

  /// What PROCESS_STATUS says now.
  [[nodiscard]] process_status_t Status();
  /// With its options, as given to LCM.
  [[nodiscard]] std::string url() const;

 protected:
  Result<void> SubscribeBytes(const std::string& channel,
                              int64_t fingerprint,
                              SubscribeOptions options,
                              BytesHandler handler) override;
  Result<void> PublishBytes(const std::string& channel, std::span<const std::byte> bytes) override;

 private:
  struct Impl;
  Result<void> AddSubscription(const std::string& channel,
                               std::optional<int64_t> fingerprint,
                               SubscribeOptions options,
                               BytesHandler handler);
  explicit LiveBus(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage
