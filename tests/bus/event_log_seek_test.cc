// Seeking a time finds what reading from the front finds.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/rng.h"
#include "tests/bus/support/mixed_log.h"
#include "tests/bus/support/temporary_folder.h"

namespace vantage {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000;  // us
constexpr int64_t kSmallest = std::numeric_limits<int64_t>::min();

struct EventLogSeek : testing::Test {
  void WriteLog(const std::vector<int64_t>& utimes, uint32_t most_bytes) {
    Rng rng(3);
    auto writer = std::move(EventLogWriter::Create(file)).value();
    for (const int64_t utime : utimes) {
      const std::vector<std::byte> data(rng.Below(most_bytes), std::byte{0xED});
      ASSERT_TRUE(writer->Write(utime, "CH", data).ok());
    }
    ASSERT_TRUE(writer->Close().ok());
    reader = std::move(EventLogReader::Open(file)).value();
  }

  // The number of the event that comes after a seek; -1: none.
  int64_t Seek(int64_t utime) {
    reader->SeekUtime(utime);
    const std::optional<LogEventView> event = reader->NextView();
    return event ? event->number : -1;
  }

  TemporaryFolder folder;
  std::filesystem::path file = folder.path() / "test.log";
  std::unique_ptr<EventLogReader> reader;
};

std::vector<int64_t> RisingTimes(int count) {
  Rng rng(1);
  std::vector<int64_t> utimes;
  int64_t utime = kStart;
  for (int i = 0; i < count; ++i) utimes.push_back(utime += rng.Below(3) * 1000);
  return utimes;
}

TEST_F(EventLogSeek, FindsWhatALinearSearchFinds) {
  const std::vector<int64_t> utimes = RisingTimes(3000);
  WriteLog(utimes, 8000);
  ASSERT_GT(std::filesystem::file_size(file), 8U << 20U);
  Rng rng(2);
  for (int i = 0; i < 300; ++i) {
    const int64_t utime = kStart - 5000 + rng.Below(3'050'000);
    const auto expected = std::ranges::lower_bound(utimes, utime);
    EXPECT_EQ(Seek(utime), expected == utimes.end() ? -1 : expected - utimes.begin()) << utime;
  }
  EXPECT_EQ(Seek(kSmallest), 0);
  EXPECT_EQ(Seek(std::numeric_limits<int64_t>::max()), -1);
  EXPECT_FALSE(reader->damage().any());
}

TEST_F(EventLogSeek, GoesOnToTheEndAndDoesNotCountWhatItPassed) {
  WriteLog(RisingTimes(2000), 3000);
  const int64_t first = Seek(kStart + 1'000'000);
  int64_t count = 1;
  while (reader->NextView()) ++count;
  EXPECT_EQ(first + count, 2000);
  EXPECT_FALSE(reader->damage().any());
}

TEST_F(EventLogSeek, LargeMessagesAndOneWrongTime) {
  std::vector<int64_t> utimes;
  for (int64_t i = 0; i < 30; ++i) utimes.push_back(kStart + 1000 * i);
  utimes[15] = kStart * 3;
  WriteLog(utimes, 3 << 20);
  for (const int64_t i : {0, 1, 7, 14, 16, 22, 29}) {
    const int64_t found = Seek(kStart + 1000 * i);
    // An event whose time is far ahead is a place at or after the time, if it is met first.
    EXPECT_TRUE(found == i || (found == 15 && i > 15)) << found << " for " << i;
  }
}

TEST_F(EventLogSeek, FindsTheTimeSpanAndStaysWhereItIs) {
  const std::vector<int64_t> utimes = RisingTimes(3000);
  WriteLog(utimes, 3000);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(reader->NextView());
  const auto span = reader->FindTimeSpan();
  ASSERT_TRUE(span);
  EXPECT_EQ(span->first_utime, utimes.front());
  EXPECT_EQ(span->last_utime, utimes.back());
  EXPECT_EQ(reader->NextView()->number, 10);
}

TEST_F(EventLogSeek, TimeSpanOfALogThatEndsInsideAnEvent) {
  const std::vector<int64_t> utimes = RisingTimes(50);
  WriteLog(utimes, 3000);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  reader = std::move(EventLogReader::Open(file)).value();
  EXPECT_EQ(reader->FindTimeSpan()->last_utime, utimes[48]);
  EXPECT_FALSE(reader->damage().any());
}

// Where the middle of the file is no log at all.
TEST_F(EventLogSeek, AcrossGarbage) {
  const std::vector<int64_t> utimes = RisingTimes(2000);
  WriteLog(utimes, 4000);
  {
    std::FILE* stream = std::fopen(file.c_str(), "r+b");
    ASSERT_NE(stream, nullptr);
    std::fseek(stream, 1 << 20, SEEK_SET);
    const std::vector<char> garbage(2 << 20, 'x');
    EXPECT_EQ(std::fwrite(garbage.data(), 1, garbage.size(), stream), garbage.size());
    std::fclose(stream);
  }
  reader = std::move(EventLogReader::Open(file)).value();
  EXPECT_EQ(Seek(utimes[100]), std::ranges::lower_bound(utimes, utimes[100]) - utimes.begin());
  EXPECT_EQ(Seek(utimes[1900]), std::ranges::lower_bound(utimes, utimes[1900]) - utimes.begin());
}

TEST_F(EventLogSeek, InMixedLogs) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const MixedLog log = MakeMixedLog(3000, seed);
    const MemoryFile memory(log.bytes);
    reader = std::move(EventLogReader::Open(memory.path())).value();
    for (const int64_t i : {0, 1, 1499, 2000, 2998}) EXPECT_EQ(Seek(kStart + 1000 * i), i) << seed;
  }
}

}  // namespace
}  // namespace vantage
