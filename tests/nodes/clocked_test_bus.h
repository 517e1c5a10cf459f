#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bus/bus.h"
#include "bus/message_check.h"

namespace vantage {

/// A bus in memory with a clock that the test sets.
class ClockedTestBus : public Bus {
 public:
  void RecordStage(const std::string&, double) override {}
  void RecordLost(const std::string&, int64_t) override {}
  void SetState(const std::string& text) override { state = text; }
  [[nodiscard]] int64_t NowUtime() const override { return now; }

  template <class Message>
  void Send(const std::string& channel, const Message& message) {
    handlers.at(channel)({channel, now}, Encode(message));
  }
  template <class Message>
  std::vector<Message> Take(const std::string& channel) {
    std::vector<Message> messages;
    for (const std::vector<std::byte>& bytes : sent[channel]) {
      messages.push_back(*DecodeChecked<Message>(bytes));
    }
    sent.erase(channel);
    return messages;
  }

  int64_t now = 1'700'000'000'000'000;
  std::string state = "ok";
  std::map<std::string, BytesHandler> handlers;
  std::map<std::string, std::vector<std::vector<std::byte>>> sent;

 protected:
  Result<void> SubscribeBytes(const std::string& channel,
                              int64_t,
                              SubscribeOptions,
                              BytesHandler handler) override {
    handlers[channel] = std::move(handler);
    return {};
  }
  Result<void> PublishBytes(const std::string& channel, std::span<const std::byte> bytes) override {
    sent[channel].emplace_back(bytes.begin(), bytes.end());
    return {};
  }
};

}  // namespace vantage
