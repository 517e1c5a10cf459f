#include "tools/support/log_comparison.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <vector>

#include "bus/event_log.h"
#include "bus/message_check.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"
#include "vantage/orientation_histogram_t.hpp"

namespace vantage {
namespace {

struct Event {
  int64_t utime = 0;
  std::string channel;
  std::vector<std::byte> bytes;
};

Event Objects(int64_t second, int64_t seq, double x = 0.0) {
  object_estimates_v3_t message{};
  message.utime = second * 1'000'000;
  message.seq = seq;
  message.num_objects = 1;
  message.objects.resize(1);
  message.objects[0].trans[0] = x;
  return {message.utime + 200'000, "OBJECTS", Encode(message)};
}

Event Histogram(int64_t second, int32_t instance, float weight = 0.5F) {
  orientation_histogram_t message{};
  message.utime = second * 1'000'000;
  message.seq = second;
  message.instance_id = instance;
  message.num_cells = 1;
  message.cell = {3};
  message.weight = {weight};
  return {message.utime + 200'000, "ORIENTATION_HISTOGRAM", Encode(message)};
}

Event NextView(int64_t second, int64_t seq, const std::string& reason) {
  next_view_t message{};
  message.utime = second * 1'000'000;
  message.seq = seq;
  message.reason = reason;
  return {message.utime + 300'000, "NEXT_VIEW", Encode(message)};
}

std::vector<Event> RunOf(int64_t seconds) {
  std::vector<Event> events;
  for (int64_t i = 1; i <= seconds; ++i) {
    events.push_back(Objects(i, i));
    events.push_back(Histogram(i, 0));
    events.push_back(Histogram(i, 1));
  }
  return events;
}

class LogComparisonTest : public ScratchTest {
 protected:
  void Write(const std::string& name, const std::vector<Event>& events) const {
    auto writer = EventLogWriter::Create(scratch() / name);
    ASSERT_TRUE(writer.ok());
    for (const Event& each : events) {
      ASSERT_TRUE((*writer)->Write(each.utime, each.channel, each.bytes).ok());
    }
    ASSERT_TRUE((*writer)->Close().ok());
  }
  [[nodiscard]] LogComparison Compare(const std::vector<Event>& first,
                                      const std::vector<Event>& second) const {
    Write("first.lcm", first);
    Write("second.lcm", second);
    Result<LogComparison> compared =
        CompareLogs(scratch() / "first.lcm", scratch() / "second.lcm", ".*", {});
    EXPECT_TRUE(compared.ok()) << compared.error().message;
    return compared.ok() ? *compared : LogComparison{};
  }
};

TEST_F(LogComparisonTest, EqualLogsAreClean) {
  const LogComparison compared = Compare(RunOf(20), RunOf(20));
  EXPECT_TRUE(compared.clean());
  EXPECT_EQ(compared.first(), nullptr);
  EXPECT_EQ(compared.channels.at("OBJECTS").matched, 20);
  EXPECT_EQ(compared.channels.at("ORIENTATION_HISTOGRAM").identical, 40);
  const std::string text = ComparisonText(compared, {"recorded", "recomputed"});
  EXPECT_NE(text.find("No difference."), std::string::npos) << text;
  EXPECT_NE(text.find("compute_time"), std::string::npos) << text;
}

TEST_F(LogComparisonTest, TellsTheFirstDifferenceByMessageTime) {
  std::vector<Event> second = RunOf(20);
  second[3 * 11] = Objects(12, 12, 0.002);
  second[3 * 5 + 2] = Histogram(6, 1, 0.25F);
  const LogComparison compared = Compare(RunOf(20), second);
  EXPECT_FALSE(compared.clean());
  ASSERT_NE(compared.first(), nullptr);
  EXPECT_EQ(compared.first()->channel, "ORIENTATION_HISTOGRAM");
  EXPECT_EQ(compared.first()->first_event, 17);
  EXPECT_EQ(compared.first()->utime, 6'000'000);
  EXPECT_EQ(compared.channels.at("OBJECTS").within, 19);
  EXPECT_NEAR(compared.channels.at("OBJECTS").position_mm, 2.0, 1e-9);
  const std::string text = ComparisonText(compared, {"recorded", "recomputed"});
  for (const char* part : {"First difference: ORIENTATION_HISTOGRAM, utime 6000000, seq 6",
                           "event 17 of the recorded log",
                           "weight[0]",
                           "recorded: 0.5",
                           "recomputed: 0.25"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << text;
  }
}

TEST_F(LogComparisonTest, MissingMessagesAreDifferencesOnBothSides) {
  std::vector<Event> fewer = RunOf(20);
  fewer.erase(fewer.begin() + 3 * 4);
  for (const bool swapped : {false, true}) {
    const LogComparison compared = swapped ? Compare(fewer, RunOf(20)) : Compare(RunOf(20), fewer);
    EXPECT_FALSE(compared.clean());
    EXPECT_EQ(compared.channels.at("OBJECTS").matched, 19) << "the others find each other";
    EXPECT_EQ(compared.channels.at("OBJECTS").within, 19);
    ASSERT_NE(compared.first(), nullptr);
    EXPECT_FALSE(compared.first()->field.has_value());
    EXPECT_EQ(compared.first()->utime, 5'000'000);
    EXPECT_EQ(compared.first()->first_event, swapped ? -1 : 12);
  }
  // A channel that is not there at all.
  std::vector<Event> none;
  for (const Event& each : RunOf(20)) {
    if (each.channel != "OBJECTS") none.push_back(each);
  }
  EXPECT_FALSE(Compare(RunOf(20), none).clean());
  EXPECT_FALSE(Compare(none, RunOf(20)).clean());
  EXPECT_EQ(Compare(none, RunOf(20)).first()->utime, 1'000'000);
  EXPECT_FALSE(Compare({NextView(1, 1, "a")}, RunOf(20)).clean());
}

TEST_F(LogComparisonTest, WhatAnswersTheEndOfTheFirstLogMayBeMissingInIt) {
  const LogComparison compared = Compare(RunOf(20), RunOf(21));
  EXPECT_TRUE(compared.clean());
  EXPECT_EQ(compared.channels.at("OBJECTS").late, 1);
  EXPECT_NE(ComparisonText(compared, {"recorded", "recomputed"}).find("3 messages"),
            std::string::npos);
  EXPECT_FALSE(Compare(RunOf(21), RunOf(20)).clean()) << "the rerun has no such excuse";
  EXPECT_FALSE(Compare(RunOf(10), RunOf(20)).clean());
  // Live stopped long before its log did.
  std::vector<Event> stopped = RunOf(10);
  stopped.push_back({20'000'000, "CAMERA", {std::byte{1}}});
  EXPECT_FALSE(Compare(stopped, RunOf(11)).clean());
}

TEST_F(LogComparisonTest, RepeatsCountOnce) {
  const std::vector<Event> plain = {NextView(1, 1, "a"), NextView(2, 2, "b")};
  const std::vector<Event> repeated = {NextView(1, 1, "a"),
                                       NextView(1, 1, "a"),
                                       NextView(1, 1, "a"),
                                       NextView(2, 2, "b"),
                                       NextView(2, 2, "b")};
  const LogComparison compared = Compare(plain, repeated);
  EXPECT_TRUE(compared.clean());
  EXPECT_EQ(compared.channels.at("NEXT_VIEW").repeats[1], 3);
  // The same seq with something else to say is another message.
  EXPECT_FALSE(Compare(plain, {plain[0], NextView(1, 1, "c"), plain[1]}).clean());
}

TEST_F(LogComparisonTest, PassesOfALogThatWasPlayedTwice) {
  std::vector<Event> twice = RunOf(10);
  for (const Event& each : RunOf(10)) twice.push_back(each);
  const LogComparison compared = Compare(twice, twice);
  EXPECT_TRUE(compared.clean());
  EXPECT_EQ(compared.channels.at("OBJECTS").matched, 20);
  std::vector<Event> second = twice;
  second.erase(second.begin());  // Of the first pass.
  const LogComparison lacking = Compare(twice, second);
  EXPECT_EQ(lacking.channels.at("OBJECTS").matched, 19);
  EXPECT_EQ(lacking.channels.at("OBJECTS").within, 19);
  EXPECT_EQ(lacking.first()->first_event, 0);
}

TEST_F(LogComparisonTest, DamageAndForeignEvents) {
  std::vector<Event> foreign = RunOf(5);
  foreign.push_back({6'000'000, "FOREIGN", std::vector<std::byte>(5, std::byte{1})});
  foreign.push_back({6'000'001, "FOREIGN", std::vector<std::byte>(5, std::byte{1})});
  EXPECT_TRUE(Compare(foreign, foreign).clean());
  EXPECT_EQ(Compare(foreign, foreign).channels.at("FOREIGN").matched, 2);

  Write("first.lcm", RunOf(20));
  Result<std::string> bytes = ReadFileBytes(scratch() / "first.lcm", size_t{1} << 20U);
  ASSERT_TRUE(bytes.ok());
  ASSERT_TRUE(WriteFileBytes(scratch() / "cut.lcm", bytes->substr(0, bytes->size() - 9)).ok());
  const Result<LogComparison> cut =
      CompareLogs(scratch() / "cut.lcm", scratch() / "first.lcm", ".*", {});
  ASSERT_TRUE(cut.ok());
  EXPECT_FALSE(cut->clean());
  EXPECT_FALSE(cut->damage[0].empty());
  EXPECT_FALSE(CompareLogs(scratch() / "none.lcm", scratch() / "first.lcm", ".*", {}).ok());
  EXPECT_FALSE(CompareLogs(scratch() / "first.lcm", scratch() / "first.lcm", "(", {}).ok());
}

// More than may wait: it ends, and says that nothing matches.
TEST_F(LogComparisonTest, ManyWithoutMatch) {
  std::vector<Event> first;
  std::vector<Event> second;
  for (int64_t i = 1; i <= 6000; ++i) {
    first.push_back(Objects(i, i));
    second.push_back(Objects(10'000 + i, i));
  }
  const LogComparison compared = Compare(first, second);
  EXPECT_FALSE(compared.clean());
  EXPECT_EQ(compared.channels.at("OBJECTS").matched, 0);
  EXPECT_EQ(compared.channels.at("OBJECTS").count[1], 6000);
}

}  // namespace
}  // namespace vantage
