#pragma once

#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "bus/bus.h"

namespace vantage {

/// A bus without a wire: hands messages to the handlers at once and keeps what is published.
class TestBus : public Bus {
 public:
  template <class Message>
  void Send(const std::string& channel, const Message& message) {
    Deliver(channel, Message::getHash(), Encode(message));
  }

  /// All messages of a type published on a channel so far.
  template <class Message>
  std::vector<Message> Published(const std::string& channel) const {
    std::vector<Message> messages;
    for (const auto& [name, bytes] : published_) {
      if (name != channel) continue;
      Result<Message> message = DecodeChecked<Message>(bytes);
      if (message) messages.push_back(std::move(*message));
    }
    return messages;
  }
  template <class Message>
  Message Last(const std::string& channel) const {
    const std::vector<Message> messages = Published<Message>(channel);
    VANTAGE_CHECK(!messages.empty(), channel);
    return messages.back();
  }
  size_t Count(const std::string& channel) const {
    size_t count = 0;
    for (const auto& published : published_) count += published.first == channel ? 1 : 0;
    return count;
  }
  void ForgetPublished() { published_.clear(); }
  /// As new, without the handlers of a node that has ended.
  void Reset() {
    subscriptions_.clear();
    published_.clear();
  }
  /// All that was published, for comparing runs.
  const std::vector<std::pair<std::string, std::vector<std::byte>>>& published() const {
    return published_;
  }
  const std::string& state() const { return state_; }

  void RecordStage(const std::string& /*stage*/, double /*seconds*/) override {}
  void RecordLost(const std::string& /*channel*/, int64_t /*count*/) override {}
  void SetState(const std::string& state) override { state_ = state; }
  [[nodiscard]] int64_t NowUtime() const override { return 0; }

 protected:
  Result<void> SubscribeBytes(const std::string& channel,
                              int64_t fingerprint,
                              SubscribeOptions /*options*/,
                              BytesHandler handler) override {
    subscriptions_.push_back({std::regex(channel), fingerprint, std::move(handler)});
    return {};
  }
  Result<void> PublishBytes(const std::string& channel, std::span<const std::byte> bytes) override {
    published_.emplace_back(channel, std::vector<std::byte>(bytes.begin(), bytes.end()));
    return {};
  }

 private:
  struct Subscription {
    std::regex channel;
    int64_t fingerprint;
    BytesHandler handler;
  };

  void Deliver(const std::string& channel,
               int64_t fingerprint,
               const std::vector<std::byte>& bytes) {
    for (const Subscription& subscription : subscriptions_) {
      if (subscription.fingerprint != fingerprint) continue;
      if (!std::regex_match(channel, subscription.channel)) continue;
      Envelope envelope;
      envelope.channel = channel;
      subscription.handler(envelope, bytes);
    }
  }

  std::vector<Subscription> subscriptions_;
  std::vector<std::pair<std::string, std::vector<std::byte>>> published_;
  std::string state_ = "ok";
};

}  // namespace vantage
