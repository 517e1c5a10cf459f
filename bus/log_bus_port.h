#pragma once

#include <string>
#include <utility>

#include "bus/log_bus.h"

namespace vantage {

/// What one node sees of a LogBus: everything but the events on the held channels, of which it
/// gets those that Deliver() is called with.
class LogBus::Port : public Bus {
 public:
  Port(LogBus* bus, ChannelPattern held) : bus_(*bus), held_(std::move(held)) {}

  /// An event of a held channel, at the time of the event in hand.
  void Deliver(const LogEvent& event) const;
  [[nodiscard]] bool Holds(const std::string& channel) const { return held_.Matches(channel); }

  void RecordStage(const std::string& stage, double seconds) override {
    bus_.RecordStage(stage, seconds);
  }
  void RecordLost(const std::string& channel, int64_t count) override {
    bus_.RecordLost(channel, count);
  }
  void SetState(const std::string& state) override { bus_.SetState(state); }
  [[nodiscard]] int64_t NowUtime() const override { return bus_.NowUtime(); }

 protected:
  Result<void> SubscribeBytes(const std::string& channel,
                              int64_t fingerprint,
                              SubscribeOptions /*options*/,
                              BytesHandler handler) override {
    return bus_.AddSubscription(channel, fingerprint, std::move(handler), this);
  }
  Result<void> PublishBytes(const std::string& channel, std::span<const std::byte> bytes) override {
    return bus_.PublishBytes(channel, bytes);
  }

 private:
  LogBus& bus_;
  ChannelPattern held_;
};

}  // namespace vantage
