#include "bus/event_log_reader.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

constexpr auto kHeader = static_cast<int64_t>(EventHeader::kBytes);
constexpr int64_t kSearchedForStart = 1 << 20;  // bytes of a file that does not start as a log

Error NoLog(const std::filesystem::path& file, const std::string& why) {
  return {ErrorCode::kCorrupt,
          Format("%s is no LCM log: %s, expected a file that starts with ed a1 da 01",
                 file.c_str(),
                 why.c_str())};
}

}  // namespace

Result<std::unique_ptr<EventLogReader>> EventLogReader::Open(const std::filesystem::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    return Error{errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
                 Format("log %s can't be opened (%s), expected one of lcm-logger or vantage-log",
                        file.c_str(),
                        std::strerror(errno))};
  }
  struct stat status {};
  const bool is_file = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  std::unique_ptr<EventLogReader> reader(
      new EventLogReader(file, descriptor, is_file ? status.st_size : 0));
  const int64_t size = reader->window_.size();
  if (!is_file) return NoLog(file, "it is no regular file");
  if (size == 0) return NoLog(file, "it is empty");
  std::array<std::byte, 4> start{};
  if (!reader->window_.Peek(0, start)) {
    return NoLog(file, Format("it has %jd bytes", intmax_t{size}));
  }
  const auto sync = LoadBigEndian<uint32_t>(start);
  const int64_t searched = std::min(size, kSearchedForStart);
  if (sync != EventHeader::kSync && !reader->finder_.EventAt(0, {}) &&
      reader->finder_.FindChain(1, searched, INT64_MIN) == searched) {
    return NoLog(file,
                 Format("it starts with %02x %02x %02x %02x",
                        sync >> 24U,
                        (sync >> 16U) & 0xffU,
                        (sync >> 8U) & 0xffU,
                        sync & 0xffU));
  }
  return reader;
}

EventLogReader::EventLogReader(std::filesystem::path file, int descriptor, int64_t size)
    : file_(std::move(file)), window_(descriptor, size), finder_(window_) {}

EventLogReader::~EventLogReader() = default;

std::optional<LogEvent> EventLogReader::Next() {
  const std::optional<LogEventView> view = NextView();
  if (!view) return {};
  return LogEvent{.number = view->number,
                  .utime = view->utime,
                  .channel = std::string(view->channel),
                  .data = {view->data.begin(), view->data.end()}};
}

std::optional<LogEventView> EventLogReader::NextView() {
  while (offset_ < window_.size() && window_.error().empty()) {
    const std::optional<EventFinder::Found> found = finder_.EventAt(offset_, last_number_);
    if (!found) {
      Skip();
      continue;
    }
    const EventHeader& header = found->header;
    const std::span<const std::byte> bytes = window_.At(offset_, header.EventBytes());
    if (bytes.empty()) break;
    const std::span<const std::byte> channel =
        bytes.subspan(EventHeader::kBytes, static_cast<size_t>(header.channel_bytes));
    const LogEventView view{
        .number = header.number,
        .utime = header.utime,
        .channel = {reinterpret_cast<const char*>(channel.data()), channel.size()},
        .data = bytes.subspan(EventHeader::kBytes + channel.size()),
        .offset = offset_};
    // A number that is wrong between two that count up is not counted on from.
    const bool is_odd = last_number_ && !skipped_ && found->next_number == *last_number_ + 2;
    const int64_t number = is_odd ? *last_number_ + 1 : header.number;
    EndSkip(number);
    if (found->mended != nullptr) Mended(header, found->mended);
    finder_.Learn(header, view.channel);
    offset_ += header.EventBytes();
    last_number_ = number;
    return view;
  }
  damage_.read_error = window_.error();
  EndSkip({});
  return {};
}

void EventLogReader::Skip() {
  const int64_t size = window_.size();
  std::array<std::byte, EventHeader::kBytes> bytes{};
  const bool has_header = window_.Peek(offset_, bytes);
  const EventHeader header = has_header ? EventHeader::Load(bytes) : EventHeader{.sync = 0};
  const bool begins_event = has_header ? header.IsPlausible() : finder_.LooksLikeSync(offset_);
  const bool ends_outside = has_header && begins_event && header.EventBytes() > size - offset_;
  const bool is_next = !last_number_ || header.number == *last_number_ + 1;
  const int64_t next = finder_.FindEvent(offset_ + 1, last_number_, ends_outside && is_next);
  const bool truncates = next == size && (begins_event || size - offset_ < kHeader);
  if (truncates) damage_.truncated = true;
  if (!skipped_) {
    const char* reason = "no event begins here";
    if (begins_event || (has_header && header.sync == EventHeader::kSync)) {
      reason = truncates ? "the file ends inside the event" : "damaged header";
    }
    skipped_ = Damage::Place{.offset = offset_, .reason = reason};
    if (truncates && begins_event && last_number_) {
      skipped_->first_number = *last_number_ + 1;
      skipped_->num_events = 1;
    }
  }
  skipped_->bytes += next - offset_;
  offset_ = next;
}

// A gap of the number counts only where bytes were skipped: elsewhere somebody took events out on
// purpose, or it is the number itself that is damaged.
void EventLogReader::EndSkip(std::optional<int64_t> number) {
  if (!skipped_) return;
  constexpr int64_t kLargestGap = 1'000'000'000;
  const int64_t last = last_number_.value_or(-1);
  if (number && last >= -1 && *number > last && *number - last <= kLargestGap) {
    skipped_->first_number = last + 1;
    skipped_->num_events = *number - last - 1;
  }
  ++damage_.num_places;
  damage_.bytes_skipped += skipped_->bytes;
  damage_.events_lost += skipped_->num_events;
  AddPlace(*skipped_);
  skipped_.reset();
}

void EventLogReader::Mended(const EventHeader& header, const char* what) {
  ++damage_.events_mended;
  AddPlace({.offset = offset_,
            .bytes = 0,
            .first_number = header.number,
            .num_events = 1,
            .reason = what});
}

void EventLogReader::AddPlace(const Damage::Place& place) {
  if (damage_.places.size() < Damage::kMaxPlaces) damage_.places.push_back(place);
}

}  // namespace vantage
