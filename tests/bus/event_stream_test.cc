#include "bus/event_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/bus/support/temporary_folder.h"

namespace vantage {
namespace {

using Events = std::vector<std::pair<int64_t, std::string>>;  // utime, channel

struct EventStreamTest : testing::Test {
  void Write(const Events& events, size_t bytes = 8) {
    auto writer = EventLogWriter::Create(log);
    ASSERT_TRUE(writer.ok());
    for (const auto& [utime, channel] : events) {
      ASSERT_TRUE((*writer)->Write(utime, channel, std::vector<std::byte>(bytes)).ok());
    }
    ASSERT_TRUE((*writer)->Close().ok());
  }

  Events Read(const EventStream::Options& options = {}) {
    auto opened = EventStream::Create(options, std::move(EventLogReader::Open(log)).value());
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    stream = std::move(opened).value();
    Events events;
    while (const std::optional<LogEvent> event = stream->Next()) {
      events.emplace_back(event->utime, event->channel);
    }
    EXPECT_FALSE(stream->Next()) << "the end is the end";
    return events;
  }

  TemporaryFolder folder;
  std::filesystem::path log = folder.path() / "in.log";
  std::unique_ptr<EventStream> stream;
};

TEST_F(EventStreamTest, LeavesWhatIsInOrderAsItStands) {
  const Events events = {{5, "A"}, {5, "C"}, {5, "B"}, {7, "A"}, {500, "A"}, {500, "B"}};
  Write(events);
  for (const int64_t window : {0, 1, 100, 1'000'000}) {
    EventStream::Options options;
    options.window_us = window;
    EXPECT_EQ(Read(options), events) << window;
    EXPECT_EQ(stream->counters().num_sorted, 0);
    EXPECT_EQ(stream->counters().num_late, 0);
  }
}

TEST_F(EventStreamTest, SortsWithinTheWindowAndKeepsTheOrderOfEqualTimes) {
  Write({{100, "A"}, {90, "B"}, {100, "C"}, {90, "D"}, {120, "E"}, {111, "F"}, {140, "G"}});
  EventStream::Options options;
  options.window_us = 10;
  EXPECT_EQ(
      Read(options),
      (Events{{90, "B"}, {90, "D"}, {100, "A"}, {100, "C"}, {111, "F"}, {120, "E"}, {140, "G"}}));
  EXPECT_EQ(stream->counters().num_sorted, 3);
  EXPECT_EQ(stream->counters().num_late, 0);
}

// Against a sort of everything, where nothing is later than the window.
TEST_F(EventStreamTest, SortsAnyDisorderThatIsNoLargerThanTheWindow) {
  constexpr int64_t kWindow = 50;
  Events events;
  uint32_t state = 1;
  for (int i = 0; i < 500; ++i) {
    state = state * 1664525U + 1013904223U;
    const int64_t late = (state >> 16U) % (kWindow / 2);
    events.emplace_back(1000 + 3 * i - late, std::to_string(i));
  }
  Write(events);
  EventStream::Options options;
  options.window_us = kWindow;
  std::ranges::stable_sort(events, {}, &std::pair<int64_t, std::string>::first);
  EXPECT_EQ(Read(options), events);
  EXPECT_GT(stream->counters().num_sorted, 100);
}

TEST_F(EventStreamTest, TakesWhatIsLaterThanTheWindowAsItStands) {
  // The clock was set back by 400, with some disorder before and after.
  const Events events = {{1000, "A"}, {995, "B"}, {600, "C"}, {595, "D"}, {610, "E"}};
  Write(events);
  EventStream::Options options;
  options.window_us = 10;
  EXPECT_EQ(Read(options), (Events{{995, "B"}, {1000, "A"}, {595, "D"}, {600, "C"}, {610, "E"}}));
  EXPECT_EQ(stream->counters().num_late, 1);
  EXPECT_EQ(stream->counters().late_event, 2);
  EXPECT_DOUBLE_EQ(stream->counters().largest_step_back, 400e-6);
}

TEST_F(EventStreamTest, OneDamagedTimeCostsNoOtherItsPlace) {
  constexpr int64_t kFar = std::numeric_limits<int64_t>::max();
  constexpr int64_t kBefore = std::numeric_limits<int64_t>::min();
  const Events events = {{1, "A"}, {kFar, "B"}, {2, "C"}, {kBefore, "D"}, {3, "E"}};
  Write(events);
  for (const int64_t window : {0, 1'000'000}) {
    EventStream::Options options;
    options.window_us = window;
    EXPECT_EQ(Read(options), events) << window;
    EXPECT_EQ(stream->counters().num_late, 2);
  }
  EventStream::Options options;
  options.from_utime = 2;
  options.to_utime = 3;
  EXPECT_EQ(Read(options), (Events{{2, "C"}, {3, "E"}}));
}

TEST_F(EventStreamTest, HoldsNoMoreThanItsBytes) {
  const Events events = {{100, "A"}, {99, "B"}, {98, "C"}, {101, "D"}, {97, "E"}, {400, "F"}};
  Write(events, 1000);
  EventStream::Options options;
  options.window_us = 200;
  options.window_bytes = 2500;
  // Two wait at most: the third lets the earliest go.
  EXPECT_EQ(Read(options),
            (Events{{98, "C"}, {99, "B"}, {97, "E"}, {100, "A"}, {101, "D"}, {400, "F"}}));
}

TEST_F(EventStreamTest, ReadsSomeChannelsOfSomeTime) {
  Write({{10, "A"}, {20, "B"}, {30, "AB"}, {40, "A"}, {50, "A"}});
  EventStream::Options options;
  options.channels = "A.*";
  options.from_utime = 20;
  options.to_utime = 40;
  EXPECT_EQ(Read(options), (Events{{30, "AB"}, {40, "A"}}));
  EXPECT_EQ(stream->channels(), (std::set<std::string>{"A", "AB", "B"}));
  options.channels = "C";
  EXPECT_TRUE(Read(options).empty());
}

TEST_F(EventStreamTest, EndsSoonAfterTheEndOfWhatIsWanted) {
  Events events;
  for (int i = 0; i < 1000; ++i) events.emplace_back(1'000'000 * i, "A");
  Write(events);
  EventStream::Options options;
  options.window_us = 1'000'000;
  options.to_utime = 9'500'000;
  EXPECT_EQ(Read(options), Events(events.begin(), events.begin() + 10));
  EXPECT_LT(stream->reader().progress(), 0.2);
}

TEST_F(EventStreamTest, RefusesWhatIsNoRegularExpression) {
  Write({{10, "A"}});
  EventStream::Options options;
  options.channels = "A(";
  EXPECT_FALSE(EventStream::Create(options, std::move(EventLogReader::Open(log)).value()).ok());
}

}  // namespace
}  // namespace vantage
