#include "bus/event_stream.h"

#include <algorithm>
#include <limits>

namespace vantage {
namespace {

// Times come from outside.
int64_t Earlier(int64_t utime, int64_t by) {
  return utime < std::numeric_limits<int64_t>::min() + by ? std::numeric_limits<int64_t>::min()
                                                          : utime - by;
}

}  // namespace

Result<std::unique_ptr<EventStream>> EventStream::Create(const Options& options,
                                                         std::unique_ptr<EventLogReader> reader) {
  std::unique_ptr<EventStream> stream(new EventStream(options, std::move(reader)));
  if (!options.channels.empty()) {
    Result<ChannelPattern> pattern = ChannelPattern::Create(options.channels);
    if (!pattern) return pattern.error();
    stream->wanted_ = std::move(pattern).value();
  }
  return stream;
}

std::optional<LogEvent> EventStream::Next() {
  while (true) {
    const bool has_due =
        !waiting_.empty() &&
        (at_end_ || next_pass_ || waiting_bytes_ > options_.window_bytes ||
         waiting_.begin()->first.first <= Earlier(newest_utime_, options_.window_us));
    if (has_due) return Release();
    if (next_pass_) {
      newest_utime_ = next_pass_->utime;
      Take(*std::exchange(next_pass_, std::nullopt));
      continue;
    }
    if (at_end_) return {};
    std::optional<LogEvent> event = Read();
    if (!event) {
      at_end_ = true;
    } else if (arrivals_ > 0 && event->utime < Earlier(newest_utime_, options_.window_us)) {
      if (counters_.num_late++ == 0) counters_.late_event = event->number;
      const double step_back =
          1e-6 * (static_cast<double>(newest_utime_) - static_cast<double>(event->utime));
      counters_.largest_step_back = std::max(counters_.largest_step_back, step_back);
      next_pass_ = std::move(event);
    } else {
      if (arrivals_ == 0) newest_utime_ = event->utime;
      if (event->utime < newest_utime_) ++counters_.num_sorted;
      newest_utime_ = std::max(newest_utime_, event->utime);
      Take(std::move(*event));
    }
  }
}

// The next event that is wanted, as it stands.
std::optional<LogEvent> EventStream::Read() {
  while (const std::optional<LogEventView> event = reader_->NextView()) {
    if (channels_.size() < kMostChannels) channels_.emplace(event->channel);
    if (options_.to_utime && event->utime > *options_.to_utime) {
      // One may be damaged, and later ones may still belong before it.
      const bool is_beyond = Earlier(event->utime, options_.window_us) > *options_.to_utime;
      num_beyond_ = is_beyond ? num_beyond_ + 1 : 0;
      if (num_beyond_ > kMostBeyond) return {};
      continue;
    }
    num_beyond_ = 0;
    if (options_.from_utime && event->utime < *options_.from_utime) continue;
    std::string channel(event->channel);
    if (wanted_ && !wanted_->Matches(channel)) continue;
    return LogEvent{
        event->number, event->utime, std::move(channel), {event->data.begin(), event->data.end()}};
  }
  return {};
}

void EventStream::Take(LogEvent event) {
  waiting_bytes_ += event.data.size();
  const std::pair<int64_t, int64_t> key(event.utime, arrivals_++);
  waiting_.emplace(key, std::move(event));
}

std::optional<LogEvent> EventStream::Release() {
  const auto first = waiting_.begin();
  std::optional<LogEvent> event = std::move(first->second);
  waiting_bytes_ -= event->data.size();
  waiting_.erase(first);
  return event;
}

}  // namespace vantage
