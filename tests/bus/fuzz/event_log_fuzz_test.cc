// Logs that are flipped, cut, spliced and overwritten at random: reading ends, accounts for every
// byte, gives only events that LCM can send, and takes memory in proportion to the file. Seeks end,
// too. Run it under ASan as well.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "bus/event_log_format.h"
#include "common/rng.h"
#include "tests/bus/fuzz/count_allocations.h"
#include "tests/bus/support/mixed_log.h"

namespace vantage {
namespace {

using Bytes = std::vector<std::byte>;

// Reads all of it. @return how many events came.
int64_t ReadAll(EventLogReader& reader, size_t file_bytes) {
  int64_t used = 0;
  int64_t count = 0;
  int64_t end = 0;
  while (const std::optional<LogEventView> event = reader.NextView()) {
    EXPECT_GE(event->channel.size(), 1U);
    EXPECT_LE(event->channel.size(), kMaxChannelName);
    EXPECT_GE(event->offset, end);
    const auto bytes =
        static_cast<int64_t>(EventHeader::kBytes + event->channel.size() + event->data.size());
    end = event->offset + bytes;
    used += bytes;
    ++count;
  }
  EXPECT_LE(end, static_cast<int64_t>(file_bytes));
  EXPECT_EQ(used + reader.damage().bytes_skipped, static_cast<int64_t>(file_bytes));
  EXPECT_TRUE(reader.damage().read_error.empty());
  return count;
}

void Feed(const Bytes& bytes, Rng& rng) {
  const MemoryFile file(bytes);
  const size_t before = BytesAllocated();
  auto reader = EventLogReader::Open(file.path());
  if (!reader) return;
  ReadAll(**reader, bytes.size());
  // The window, known channels, places of damage with their words.
  EXPECT_LE(BytesAllocated() - before, 4 * bytes.size() + 1'000'000);
  const int64_t utime = static_cast<int64_t>(1'700'000'000'000'000) + rng.Below(2'000'000);
  for (const int64_t to : {utime,
                           std::numeric_limits<int64_t>::min(),
                           std::numeric_limits<int64_t>::max(),
                           int64_t{0}}) {
    (*reader)->SeekUtime(to);
    const std::optional<LogEvent> event = (*reader)->Next();
    EXPECT_GE(event ? event->utime : to, to);
  }
  const auto span = (*reader)->FindTimeSpan();
  (*reader)->SeekUtime(std::numeric_limits<int64_t>::min());
  EXPECT_EQ(span.has_value(), (*reader)->NextView().has_value());
}

Bytes Mutated(const Bytes& from, const Bytes& other, Rng& rng) {
  Bytes bytes = from;
  const auto place = [&](const Bytes& of) {
    return static_cast<std::ptrdiff_t>(rng.Below(static_cast<uint32_t>(of.size()) + 1));
  };
  for (uint32_t i = 1 + rng.Below(4); i > 0; --i) {
    const std::ptrdiff_t at = place(bytes);
    const auto rest = static_cast<std::ptrdiff_t>(bytes.size()) - at;
    const auto length = std::min<std::ptrdiff_t>(rest, rng.Below(400));
    switch (rng.Below(6)) {
      case 0:
        bytes.resize(static_cast<size_t>(at));
        break;
      case 1:
        bytes.erase(bytes.begin() + at, bytes.begin() + at + length);
        break;
      case 2: {
        const std::ptrdiff_t begin = place(other);
        bytes.insert(bytes.begin() + at, other.begin() + begin, other.end());
        break;
      }
      case 3:
        std::fill_n(bytes.begin() + at, length, std::byte(rng.Below(2) * 255));
        break;
      case 4:  // A hostile header.
        if (rest >= static_cast<std::ptrdiff_t>(EventHeader::kBytes)) {
          EventHeader{.number = static_cast<int64_t>(rng.Below(40)),
                      .utime = static_cast<int64_t>(rng.NextUint32()) << 31U,
                      .channel_bytes = static_cast<int32_t>(rng.Below(70)),
                      .data_bytes = static_cast<int32_t>(rng.NextUint32() >> rng.Below(32))}
              .Store(std::span(bytes).subspan(static_cast<size_t>(at)));
        }
        break;
      default:
        for (std::ptrdiff_t k = 0; k < length; ++k) {
          bytes[static_cast<size_t>(at + k)] = static_cast<std::byte>(rng.Below(256));
        }
    }
  }
  return bytes;
}

TEST(EventLogFuzz, MutatedLogs) {
  Rng rng(7);
  for (int round = 0; round < 3000; ++round) {
    const MixedLog log = MakeMixedLog(1 + static_cast<int>(rng.Below(30)), rng.NextUint32());
    const MixedLog other = MakeMixedLog(5, rng.NextUint32());
    Feed(Mutated(log.bytes, other.bytes, rng), rng);
    if (HasFailure()) FAIL() << "round " << round;
  }
}

TEST(EventLogFuzz, EveryTruncation) {
  Rng rng(8);
  const MixedLog log = MakeMixedLog(12, 8);
  for (size_t size = 0; size <= log.bytes.size(); ++size) {
    Feed(Bytes(log.bytes.begin(), log.bytes.begin() + static_cast<std::ptrdiff_t>(size)), rng);
  }
}

// Headers that claim everything, one behind the other: looking ahead is bounded in all, or this
// would take minutes.
TEST(EventLogFuzz, HeadersThatClaimTheRest) {
  Bytes bytes(2'000'000);
  int64_t number = 0;
  for (size_t at = 0; at + EventHeader::kBytes <= bytes.size(); at += EventHeader::kBytes) {
    EventHeader{.number = number += 3,
                .utime = number,
                .channel_bytes = 1,
                .data_bytes = static_cast<int32_t>(bytes.size() - at) / 2}
        .Store(std::span(bytes).subspan(at));
  }
  Rng rng(9);
  Feed(bytes, rng);
}

}  // namespace
}  // namespace vantage
