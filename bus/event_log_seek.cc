// Finding a time in a log without reading all of it.
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "bus/event_log_reader.h"

namespace vantage {
namespace {

constexpr int64_t kReadThrough = 1 << 20;  // bytes that are read rather than halved
constexpr int64_t kSmallest = std::numeric_limits<int64_t>::min();

}  // namespace

// Halves the file. A place counts as that of the events there when they lead to each other, and if
// possible when their numbers are greater than those before, which a log inside of a message lacks.
void EventLogReader::SeekUtime(int64_t utime) {
  int64_t begin = 0;
  int64_t end = window_.size();
  int64_t min_number = kSmallest;
  while (utime != kSmallest && end - begin > kReadThrough) {
    const int64_t middle = begin + (end - begin) / 2;
    const int64_t near = std::min(end, middle + kReadThrough);
    int64_t place = finder_.FindChain(middle, near, min_number);
    if (place == near) place = finder_.FindChain(middle, end, kSmallest);
    const std::optional<EventHeader> header =
        place < end ? finder_.TypicalHeader(place) : std::nullopt;
    if (header && header->utime < utime) {
      begin = place;
      min_number = header->number;
    } else {
      end = middle;
    }
  }
  const Damage damage = damage_;
  MoveTo(begin, {});
  int64_t at = begin;
  std::optional<int64_t> number_before;
  while (utime != kSmallest) {
    const std::optional<LogEventView> event = NextView();
    at = event ? event->offset : window_.size();
    if (!event || event->utime >= utime) break;
    number_before = last_number_;
  }
  MoveTo(at, number_before);
  damage_ = damage;
}

std::optional<EventLogReader::TimeSpan> EventLogReader::FindTimeSpan() {
  const Damage damage = damage_;
  const int64_t offset = offset_;
  const std::optional<int64_t> number = last_number_;
  const std::optional<Damage::Place> skipped = skipped_;
  MoveTo(0, {});
  std::optional<TimeSpan> span;
  if (const std::optional<LogEventView> first = NextView()) {
    span = TimeSpan{.first_utime = first->utime, .last_utime = first->utime};
  }
  const int64_t size = window_.size();
  bool found = !span;
  for (int64_t tail = 1 << 16; !found; tail *= 16) {
    const int64_t from = std::max<int64_t>(0, size - tail);
    const int64_t begin = from == 0 ? 0 : finder_.FindChain(from, size, kSmallest);
    MoveTo(begin, {});
    while (const std::optional<LogEventView> event = NextView()) {
      span->last_utime = event->utime;
      found = true;
    }
    found = found || from == 0;
  }
  damage_ = damage;
  MoveTo(offset, number);
  skipped_ = skipped;
  return span;
}

void EventLogReader::MoveTo(int64_t offset, std::optional<int64_t> last_number) {
  offset_ = offset;
  last_number_ = last_number;
  skipped_.reset();
}

}  // namespace vantage
