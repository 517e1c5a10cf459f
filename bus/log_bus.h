#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/bus.h"
#include "bus/channel_pattern.h"
#include "bus/event_log.h"
#include "bus/event_stream.h"
#include "bus/process_status.h"
#include "vantage/log_header_t.hpp"

namespace vantage {

/// A recorded log in place of the wire: events come in the log's order, and what handlers publish
/// for one is delivered, in turn, before the next. Nothing is ever let go: SubscribeOptions make no
/// difference. What is published goes to the output log, stamped with the time of the event in
/// hand. One thread, and the same output for the same log on every run.
class LogBus : public Bus {
 public:
  /// A bus for one node, which gets events of some channels when somebody decides so.
  class Port;

  struct Options {
    EventStream::Options input;  ///< what of the log is read
    /// Channels whose recorded events are not delivered, because nodes on this bus publish them
    /// anew: a regular expression for the whole name. Empty: none.
    std::string suppress;
    /// Delivered events go to the output too, each before what is published for it; not the
    /// input's LOG_HEADER.
    bool copy_inputs = false;
    /// First event of the output. Its utime and schemas are filled in.
    log_header_t header{};
  };

  struct Counters {
    int64_t num_events = 0;      ///< read
    int64_t num_suppressed = 0;  ///< of these
    int64_t num_delivered = 0;   ///< calls of handlers, for events and for what was published
    int64_t num_published = 0;
    int64_t num_lost = 0;                          ///< by gaps in seq
    std::map<std::string, int64_t> decode_errors;  ///< by channel
    std::string first_decode_error;                ///< in words; empty: none
  };

  /// Looks at the first event, whose time is NowUtime() before Run().
  /// @param output may be null. The caller closes it after Run().
  /// Errors: `suppress` or `input.channels` is no regular expression.
  static Result<std::unique_ptr<LogBus>> Create(const Options& options,
                                                std::unique_ptr<EventLogReader> input,
                                                EventLogWriter* output);

  /// Events on channels that match `held` reach the port's subscribers by Port::Deliver() alone.
  /// The bus owns it. Errors: no regular expression.
  Result<Port*> AddPort(const std::string& held);
  /// `watcher` sees every event that is read, also one that is suppressed, before any other.
  void Watch(std::function<void(const LogEvent&)> watcher) { watcher_ = std::move(watcher); }

  /// Delivers the next event and all that follows from it; false at the end of the log.
  /// Errors: the output can't be written, or handlers answer each other without end.
  Result<bool> Step();
  /// Steps to the end.
  Result<void> Run();

  void RecordStage(const std::string& stage, double seconds) override;
  void RecordLost(const std::string& channel, int64_t count) override;
  void SetState(const std::string& state) override;
  [[nodiscard]] int64_t NowUtime() const override { return now_utime_; }

  [[nodiscard]] const Counters& counters() const { return counters_; }
  [[nodiscard]] const EventStream& input() const { return *input_; }
  /// State and stages as the nodes recorded them; no channels.
  [[nodiscard]] process_status_t Status();

  static constexpr int kMaxAnswers = 100'000;  ///< messages published for one event

  ~LogBus() override;
  LogBus(const LogBus&) = delete;
  LogBus& operator=(const LogBus&) = delete;

 protected:
  Result<void> SubscribeBytes(const std::string& channel,
                              int64_t fingerprint,
                              SubscribeOptions options,
                              BytesHandler handler) override;
  Result<void> PublishBytes(const std::string& channel, std::span<const std::byte> bytes) override;

 private:
  struct Subscription {
    ChannelPattern channel;
    int64_t fingerprint;
    BytesHandler handler;
    const Port* port;  // Null: of the bus itself.
  };
  struct Message {
    std::string channel;
    std::vector<std::byte> bytes;
  };

  LogBus(const Options& options, std::unique_ptr<EventStream> input, EventLogWriter* output);

  Result<void> WriteHeader();
  Result<void> DeliverPublished();
  Result<void> AddSubscription(const std::string& channel,
                               int64_t fingerprint,
                               BytesHandler handler,
                               const Port* port);
  void Deliver(const std::string& channel, std::span<const std::byte> bytes);
  void DeliverTo(const Subscription& subscription,
                 const std::string& channel,
                 std::span<const std::byte> bytes);

  log_header_t header_;
  bool copy_inputs_;
  std::unique_ptr<EventStream> input_;
  EventLogWriter* output_;
  std::optional<ChannelPattern> suppress_;
  std::function<void(const LogEvent&)> watcher_;
  std::vector<std::unique_ptr<Port>> ports_;
  std::optional<LogEvent> next_;
  bool started_ = false;
  int64_t now_utime_ = 0;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
  std::deque<Message> published_;
  Counters counters_;
  ProcessStatus status_;
};

/// The names and fingerprints of all message types.
void FillSchemas(log_header_t* header);

}  // namespace vantage
