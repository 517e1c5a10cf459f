#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include "bus/message_check.h"
#include "bus/sequence_tracker.h"
#include "common/result.h"

namespace vantage {

/// How messages wait between arrival and their handler.
struct SubscribeOptions {
  enum class Keep {
    kLatest,  ///< One slot: a newer message replaces one that waits, and that is counted.
    kAll,     ///< A queue bounded in bytes; when full the oldest goes, and that is counted.
  };
  Keep keep = Keep::kAll;
  size_t queue_bytes = 4U << 20U;  ///< bytes, for kAll
};

/// What is known of a message besides its content.
struct Envelope {
  std::string channel;
  int64_t receive_utime = 0;  ///< us since the epoch at arrival; of the event, from a log
  int64_t num_skipped = 0;    ///< of this channel and subscription, let go since the last one
};

/// Where nodes send and receive, on the wire (LiveBus) or over a log (LogBus). Handlers run on the
/// thread that drives the bus, one at a time, in the order of arrival; what a handler is given has
/// passed the checks of bytes that come from outside.
class Bus {
 public:
  virtual ~Bus() = default;

  /// Calls `handler(envelope, message)` for messages of a type on a channel. A channel is a name,
  /// or a regular expression that must match the whole name. Gaps in the message's seq, where it
  /// has one, are recorded as lost.
  template <class Message, class Handler>
  Result<void> Subscribe(const std::string& channel, SubscribeOptions options, Handler handler) {
    return SubscribeBytes(channel,
                          Message::getHash(),
                          options,
                          [this, handler = std::move(handler), sequence = SequenceTracker()](
                              const Envelope& envelope, std::span<const std::byte> bytes) mutable {
                            Result<Message> message = DecodeChecked<Message>(bytes);
                            if (!message) return false;
                            if constexpr (requires { message->seq; }) {
                              std::string sender = envelope.channel;
                              if constexpr (requires { message->name; })
                                sender += '/' + message->name;
                              const int64_t lost =
                                  sequence.Add(sender, message->seq, envelope.num_skipped);
                              if (lost > 0) RecordLost(envelope.channel, lost);
                            }
                            handler(envelope, *message);
                            return true;
                          });
  }

  /// Sends a message whose counts equal its vectors' sizes. Errors: the system refuses.
  template <class Message>
  Result<void> Publish(const std::string& channel, const Message& message) {
    return PublishBytes(channel, Encode(message));
  }

  /// For the process status: a stage of the owner's work took `seconds`.
  virtual void RecordStage(const std::string& stage, double seconds) = 0;
  /// For the process status: messages of a channel that never arrived, found by a gap in seq.
  virtual void RecordLost(const std::string& channel, int64_t count) = 0;
  /// For the process status: "ok", or what is wrong in one sentence.
  virtual void SetState(const std::string& state) = 0;
  /// us since the epoch: the wall clock when live, the time of the event in hand over a log.
  [[nodiscard]] virtual int64_t NowUtime() const = 0;

 protected:
  /// Returns false when the bytes could not be decoded, which is counted.
  using BytesHandler = std::function<bool(const Envelope&, std::span<const std::byte>)>;

  virtual Result<void> SubscribeBytes(const std::string& channel,
                                      int64_t fingerprint,
                                      SubscribeOptions options,
                                      BytesHandler handler) = 0;
  virtual Result<void> PublishBytes(const std::string& channel,
                                    std::span<const std::byte> bytes) = 0;
};

}  // namespace vantage
