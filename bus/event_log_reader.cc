#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "bus/channel_pattern.h"
#include "bus/event_log.h"
#include "common/format.h"

namespace vantage {
namespace {

constexpr auto kLongestChannel = static_cast<int32_t>(kMaxChannelName);
constexpr int64_t kScanBytes = 1 << 16;  // at a time

bool IsPlausible(const EventHeader& header) {
  return header.channel_bytes >= 1 && header.channel_bytes <= kLongestChannel &&
         header.data_bytes >= 0 && header.data_bytes <= EventLogReader::kMaxEventBytes;
}

Error NoLog(const std::filesystem::path& file, const std::string& why) {
  return {ErrorCode::kCorrupt,
          Format("%s is no LCM log: %s, expected a file that starts with ed a1 da 01",
                 file.c_str(),
                 why.c_str())};
}

}  // namespace

std::string EventLogReader::Damage::Describe() const {
  std::string text = Format("%lld bytes skipped in %lld places, %lld events lost",
                            static_cast<long long>(bytes_skipped),
                            static_cast<long long>(num_places),
                            static_cast<long long>(events_lost));
  if (truncated) text += ", the file ends inside an event";
  if (!read_error.empty()) text += ", reading stopped: " + read_error;
  return text;
}

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
  if (!is_file) return NoLog(file, "it is no regular file");
  if (reader->size_ == 0) return NoLog(file, "it is empty");
  std::array<std::byte, 4> start{};
  if (reader->size_ < 4 || !reader->ReadAt(0, start)) {
    return NoLog(file, Format("it has %lld bytes", static_cast<long long>(reader->size_)));
  }
  const auto sync = LoadBigEndian<uint32_t>(start);
  if (sync != EventHeader::kSync) {
    return NoLog(file,
                 Format("it starts with %02x %02x %02x %02x",
                        sync >> 24U,
                        (sync >> 16U) & 0xffU,
                        (sync >> 8U) & 0xffU,
                        sync & 0xffU));
  }
  return reader;
}

EventLogReader::~EventLogReader() { close(descriptor_); }

std::optional<LogEvent> EventLogReader::Next() {
  while (offset_ < size_ && damage_.read_error.empty()) {
    const std::optional<EventHeader> header = HeaderAt(offset_);
    if (!header || !IsWhole(offset_, *header)) {
      const int64_t next = FindHeader(offset_ + 1, size_);
      const bool begins_event = header.has_value() || size_ - offset_ < 28;
      if (next == size_ && begins_event) damage_.truncated = true;
      Skip(next);
      continue;
    }
    LogEvent event{.number = header->number, .utime = header->utime, .channel = {}, .data = {}};
    event.channel.resize(static_cast<size_t>(header->channel_bytes));
    event.data.resize(static_cast<size_t>(header->data_bytes));
    const int64_t channel_at = offset_ + static_cast<int64_t>(EventHeader::kBytes);
    if (!ReadAt(channel_at, std::as_writable_bytes(std::span(event.channel))) ||
        !ReadAt(channel_at + header->channel_bytes, event.data)) {
      break;
    }
    offset_ += header->EventBytes();
    CountLost(event.number);
    return event;
  }
  return {};
}

double EventLogReader::progress() const {
  return size_ == 0 ? 1.0 : static_cast<double>(offset_) / static_cast<double>(size_);
}

bool EventLogReader::ReadAt(int64_t offset, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = pread(descriptor_, bytes.data(), bytes.size(), offset);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      damage_.read_error = count < 0 ? std::strerror(errno) : "the file became shorter";
      return false;
    }
    bytes = bytes.subspan(static_cast<size_t>(count));
    offset += count;
  }
  return true;
}

std::optional<EventHeader> EventLogReader::HeaderAt(int64_t offset) {
  std::array<std::byte, EventHeader::kBytes> bytes{};
  if (size_ - offset < static_cast<int64_t>(bytes.size()) || !ReadAt(offset, bytes)) return {};
  std::optional<EventHeader> header = EventHeader::Load(bytes);
  if (header && !IsPlausible(*header)) header.reset();
  return header;
}

// The header has no checksum. Its lengths are believed when another header follows, and when none
// lies inside: then what follows is the damaged part.
bool EventLogReader::IsWhole(int64_t offset, const EventHeader& header) {
  const int64_t end = offset + header.EventBytes();
  if (end > size_) return false;
  std::array<std::byte, 4> sync{};
  if (size_ - end < static_cast<int64_t>(sync.size())) return true;
  if (!ReadAt(end, sync)) return false;
  return LoadBigEndian<uint32_t>(sync) == EventHeader::kSync || FindHeader(offset + 1, end) == end;
}

// The first plausible header that begins in [begin, end); end when there is none.
int64_t EventLogReader::FindHeader(int64_t begin, int64_t end) {
  constexpr auto kHeader = static_cast<int64_t>(EventHeader::kBytes);
  std::vector<std::byte> window;
  for (int64_t at = begin; at < end; at += kScanBytes) {
    const int64_t count = std::min(kScanBytes + kHeader - 1, size_ - at);
    if (count < kHeader) return end;
    window.resize(static_cast<size_t>(count));
    if (!ReadAt(at, window)) return end;
    const int64_t last = std::min({kScanBytes, end - at, count - kHeader + 1});
    for (int64_t i = 0; i < last; ++i) {
      if (window[static_cast<size_t>(i)] != std::byte{EventHeader::kSync >> 24U}) continue;
      const auto header = EventHeader::Load(std::span(window).subspan(static_cast<size_t>(i)));
      if (header && IsPlausible(*header)) return at + i;
    }
  }
  return end;
}

void EventLogReader::Skip(int64_t end) {
  if (skipped_ == 0) ++damage_.num_places;
  skipped_ += end - offset_;
  damage_.bytes_skipped += end - offset_;
  offset_ = end;
}

// A gap of the number counts only where bytes were skipped: elsewhere somebody took events out on
// purpose, or it is the number itself that is damaged.
void EventLogReader::CountLost(int64_t number) {
  constexpr int64_t kLargestGap = 1'000'000'000;
  const bool ordered = last_number_ && number > *last_number_ && *last_number_ >= 0;
  if (skipped_ > 0 && ordered && number - *last_number_ <= kLargestGap) {
    damage_.events_lost += number - *last_number_ - 1;
  }
  skipped_ = 0;
  last_number_ = number;
}

}  // namespace vantage
