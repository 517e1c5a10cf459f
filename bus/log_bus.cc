#include "bus/log_bus.h"

#include <utility>

#include "bus/log_bus_port.h"
#include "bus/message_schema.h"
#include "common/format.h"

namespace vantage {

void FillSchemas(log_header_t* header) {
  header->schema_names.clear();
  header->schema_fingerprints.clear();
  for (const MessageSchema& schema : AllSchemas()) {
    header->schema_names.emplace_back(schema.name);
    header->schema_fingerprints.push_back(schema.fingerprint());
  }
  header->num_schemas = static_cast<int32_t>(header->schema_names.size());
}

LogBus::LogBus(const Options& options, std::unique_ptr<EventStream> input, EventLogWriter* output)
    : header_(options.header),
      copy_inputs_(options.copy_inputs),
      input_(std::move(input)),
      output_(output) {}

LogBus::~LogBus() = default;

Result<std::unique_ptr<LogBus>> LogBus::Create(const Options& options,
                                               std::unique_ptr<EventLogReader> input,
                                               EventLogWriter* output) {
  Result<std::unique_ptr<EventStream>> stream =
      EventStream::Create(options.input, std::move(input));
  if (!stream) return stream.error();
  std::unique_ptr<LogBus> bus(new LogBus(options, std::move(stream).value(), output));
  if (!options.suppress.empty()) {
    Result<ChannelPattern> pattern = ChannelPattern::Create(options.suppress);
    if (!pattern) return pattern.error();
    bus->suppress_ = std::move(pattern).value();
  }
  bus->next_ = bus->input_->Next();
  if (bus->next_) bus->now_utime_ = bus->next_->utime;
  return bus;
}

Result<LogBus::Port*> LogBus::AddPort(const std::string& held) {
  Result<ChannelPattern> pattern = ChannelPattern::Create(held);
  if (!pattern) return pattern.error();
  ports_.push_back(std::make_unique<Port>(this, std::move(pattern).value()));
  return ports_.back().get();
}

Result<bool> LogBus::Step() {
  if (!started_) {
    started_ = true;
    if (Result<void> written = WriteHeader(); !written) return written.error();
    // What the nodes published when they were made.
    if (Result<void> delivered = DeliverPublished(); !delivered) return delivered.error();
  }
  if (!next_) return false;
  const LogEvent event = std::move(next_).value();
  now_utime_ = event.utime;
  ++counters_.num_events;
  if (watcher_) watcher_(event);
  if (suppress_ && suppress_->Matches(event.channel)) {
    ++counters_.num_suppressed;
  } else {
    if (output_ != nullptr && copy_inputs_ && event.channel != "LOG_HEADER") {
      if (Result<void> written = output_->Write(event.utime, event.channel, event.data); !written) {
        return written.error();
      }
    }
    Deliver(event.channel, event.data);
  }
  if (Result<void> delivered = DeliverPublished(); !delivered) return delivered.error();
  next_ = input_->Next();
  return true;
}

Result<void> LogBus::Run() {
  while (true) {
    const Result<bool> more = Step();
    if (!more) return more.error();
    if (!*more) return {};
  }
}

void LogBus::RecordStage(const std::string& stage, double seconds) {
  status_.RecordStage(stage, seconds);
}

void LogBus::RecordLost(const std::string& /*channel*/, int64_t count) {
  counters_.num_lost += count;
}

void LogBus::SetState(const std::string& state) { status_.SetState(state); }

process_status_t LogBus::Status() {
  process_status_t status{};
  status_.Fill(ProcessStatus::Clock::now(), &status);
  return status;
}

Result<void> LogBus::SubscribeBytes(const std::string& channel,
                                    int64_t fingerprint,
                                    SubscribeOptions /*options*/,
                                    BytesHandler handler) {
  return AddSubscription(channel, fingerprint, std::move(handler), nullptr);
}

Result<void> LogBus::AddSubscription(const std::string& channel,
                                     int64_t fingerprint,
                                     BytesHandler handler,
                                     const Port* port) {
  Result<ChannelPattern> pattern = ChannelPattern::Create(channel);
  if (!pattern) return pattern.error();
  subscriptions_.push_back(
      std::make_unique<Subscription>(Subscription{.channel = std::move(pattern).value(),
                                                  .fingerprint = fingerprint,
                                                  .handler = std::move(handler),
                                                  .port = port}));
  return {};
}

Result<void> LogBus::PublishBytes(const std::string& channel, std::span<const std::byte> bytes) {
  if (channel.empty() || channel.size() > kMaxChannelName) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("channel '%.80s' can't be sent on, expected a name of 1 to %zu characters",
                        channel.c_str(),
                        kMaxChannelName)};
  }
  published_.push_back({.channel = channel, .bytes = {bytes.begin(), bytes.end()}});
  return {};
}

Result<void> LogBus::WriteHeader() {
  if (output_ == nullptr) return {};
  header_.utime = now_utime_;
  FillSchemas(&header_);
  return output_->Write(now_utime_, "LOG_HEADER", Encode(header_));
}

Result<void> LogBus::DeliverPublished() {
  for (int i = 0; !published_.empty(); ++i) {
    if (i == kMaxAnswers) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("more than %d messages were published for one event, the last on %s: "
                          "handlers answer each other without end",
                          kMaxAnswers,
                          published_.front().channel.c_str())};
    }
    const Message message = std::move(published_.front());
    published_.pop_front();
    ++counters_.num_published;
    if (output_ != nullptr) {
      if (Result<void> written = output_->Write(now_utime_, message.channel, message.bytes);
          !written) {
        return written;
      }
    }
    Deliver(message.channel, message.bytes);
  }
  return {};
}

// By index: a handler may subscribe.
void LogBus::Deliver(const std::string& channel, std::span<const std::byte> bytes) {
  for (size_t i = 0; i < subscriptions_.size(); ++i) {
    const Subscription& subscription = *subscriptions_[i];
    if (subscription.port != nullptr && subscription.port->Holds(channel)) continue;
    if (subscription.channel.Matches(channel)) DeliverTo(subscription, channel, bytes);
  }
}

void LogBus::Port::Deliver(const LogEvent& event) const {
  for (size_t i = 0; i < bus_.subscriptions_.size(); ++i) {
    const Subscription& subscription = *bus_.subscriptions_[i];
    if (subscription.port != this || !subscription.channel.Matches(event.channel)) continue;
    bus_.DeliverTo(subscription, event.channel, event.data);
  }
}

void LogBus::DeliverTo(const Subscription& subscription,
                       const std::string& channel,
                       std::span<const std::byte> bytes) {
  if (subscription.handler({.channel = channel, .receive_utime = now_utime_}, bytes)) {
    ++counters_.num_delivered;
    return;
  }
  ++counters_.decode_errors[channel];
  if (!counters_.first_decode_error.empty()) return;
  const MessageSchema* schema = FindSchema(subscription.fingerprint);
  const Result<void> check =
      CheckMessageBytes(schema == nullptr ? "" : std::string(schema->name), bytes);
  counters_.first_decode_error =
      channel + ": " + (check ? "its content can't be decoded" : check.error().message);
}

}  // namespace vantage
