#include "tools/log/recorder.h"

#include <cstdio>

#include "bus/channel_pattern.h"
#include "common/format.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kPollInterval(100);
constexpr seconds kSyncInterval(1);
constexpr seconds kTellInterval(5);

}  // namespace

Result<void> Recorder::Listen(const std::string& channels, const std::string& exclude) {
  // Each for itself first, so that an error names what the user wrote.
  if (Result<ChannelPattern> wanted = ChannelPattern::Create(channels); !wanted) {
    return wanted.error();
  }
  std::string pattern = channels;
  if (!exclude.empty()) {
    if (Result<ChannelPattern> unwanted = ChannelPattern::Create(exclude); !unwanted) {
      return unwanted.error();
    }
    pattern = "(?!(?:" + exclude + ")$)(?:" + channels + ")";
  }
  return bus_->Tap(pattern,
                   {.keep = SubscribeOptions::Keep::kAll, .queue_bytes = kQueueBytes},
                   [this](const Envelope& envelope, std::span<const std::byte> bytes) {
                     Take(envelope, bytes);
                   });
}

Result<void> Recorder::Run(Recording* recording, const std::stop_token& stop) {
  recording_ = recording;
  while (!stop.stop_requested() && !error_) {
    const Clock::time_point now = Clock::now();
    if (now >= next_poll_) Poll(now);
    if (!error_) bus_->Dispatch(kPollInterval / 2);
  }
  if (!error_) Drain();
  if (!error_) {
    if (Result<void> synced = recording_->Sync(); !synced) error_ = synced.error();
  }
  if (error_) return *error_;
  return {};
}

void Recorder::Take(const Envelope& envelope, std::span<const std::byte> bytes) {
  if (error_) return;
  losses_.Add(envelope.channel, bytes, envelope.num_skipped);
  taken_utime_ = envelope.receive_utime;
  if (!RecordingFile::Takes(envelope.channel, bytes.size())) {
    losses_.AddUnfit(envelope.channel);
    return;
  }
  const Result<void> written = recording_->Write(taken_utime_, envelope.channel, bytes);
  if (!written) error_ = written.error();
}

void Recorder::Poll(Clock::time_point now) {
  next_poll_ = now + kPollInterval;
  Result<void> polled = recording_->Poll();
  if (polled && now >= next_sync_) {
    next_sync_ = now + kSyncInterval;
    polled = recording_->Sync();
  }
  if (!polled) error_ = polled.error();
  TellLosses(now);
}

void Recorder::TellLosses(Clock::time_point now) {
  if (losses_.total() == told_ || (told_at_ && now < *told_at_ + kTellInterval)) return;
  told_ = losses_.total();
  told_at_ = now;
  const std::string sentence = losses_.Describe();
  bus_->SetState(sentence);
  std::fprintf(stderr, "vantage-log: %s\n", sentence.c_str());
}

// What had arrived when the stop was asked for, and waits; the rest is for nobody.
void Recorder::Drain() {
  const int64_t end = bus_->NowUtime();
  while (!error_ && taken_utime_ <= end && bus_->Dispatch(milliseconds(0))) continue;
}

}  // namespace vantage
