#include "bus/event_log.h"

#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <set>

#include "bus/event_log_format.h"
#include "bus/wire.h"
#include "common/rng.h"
#include "tests/bus/support/temporary_folder.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<std::byte>;

struct LogFixture : testing::Test {
  // Events 0 to count - 1 on CH with their number, in bytes, as data; the offsets where they begin.
  std::vector<size_t> WriteLog(int count, size_t data_bytes = 40) {
    auto writer = EventLogWriter::Create(file);
    EXPECT_TRUE(writer.ok());
    std::vector<size_t> offsets;
    for (int i = 0; i < count; ++i) {
      offsets.push_back(static_cast<size_t>(i) * (28 + 2 + data_bytes));
      EXPECT_TRUE((*writer)->Write(1000 + i, "CH", Bytes(data_bytes, std::byte(i))).ok());
    }
    EXPECT_TRUE((*writer)->Close().ok());
    return offsets;
  }

  Bytes Load() const {
    std::ifstream stream(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
  }

  void Store(const Bytes& bytes) const {
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }

  // The numbers of the events that are read, each checked to be as it was written.
  std::vector<int64_t> ReadNumbers(size_t data_bytes = 40) {
    auto reader = EventLogReader::Open(file);
    EXPECT_TRUE(reader.ok()) << reader.error().message;
    std::vector<int64_t> numbers;
    while (const std::optional<LogEvent> event = (*reader)->Next()) {
      numbers.push_back(event->number);
      EXPECT_EQ(event->utime, 1000 + event->number);
      EXPECT_EQ(event->channel, "CH");
      EXPECT_EQ(event->data, Bytes(data_bytes, std::byte(event->number)));
    }
    damage = (*reader)->damage();
    return numbers;
  }

  static std::vector<int64_t> Range(int64_t begin, int64_t end, int64_t without = -1) {
    std::vector<int64_t> numbers;
    for (int64_t i = begin; i < end; ++i) {
      if (i != without) numbers.push_back(i);
    }
    return numbers;
  }

  TemporaryFolder folder;
  fs::path file = folder.path() / "test.log";
  EventLogReader::Damage damage;
};

using EventLog = LogFixture;

TEST_F(EventLog, ReadsWhatWasWritten) {
  WriteLog(20);
  EXPECT_EQ(ReadNumbers(), Range(0, 20));
  EXPECT_FALSE(damage.any());
  EXPECT_FALSE(damage.truncated);
}

TEST_F(EventLog, ReadsEventsWithoutData) {
  WriteLog(5, 0);
  EXPECT_EQ(ReadNumbers(0), Range(0, 5));
  EXPECT_FALSE(damage.any());
}

TEST_F(EventLog, IsWhatLcmReads) {
  WriteLog(20);
  lcm::LogFile log(file.string(), "r");
  ASSERT_TRUE(log.good());
  for (int64_t i = 0; i < 20; ++i) {
    const lcm::LogEvent* event = log.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->eventnum, i);
    EXPECT_EQ(event->timestamp, 1000 + i);
    EXPECT_EQ(event->channel, "CH");
    EXPECT_EQ(event->datalen, 40);
  }
  EXPECT_EQ(log.readNextEvent(), nullptr);
}

TEST_F(EventLog, AgreesWithLcmOnARealLog) {
  const fs::path real = fs::path(VANTAGE_SOURCE_DIR) / "../shared/data/lcm_log_drake/sample-log.00";
  if (!fs::exists(real)) GTEST_SKIP() << "no log at " << real;
  auto reader = EventLogReader::Open(real);
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  lcm::LogFile log(real.string(), "r");
  ASSERT_TRUE(log.good());
  int count = 0;
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    const lcm::LogEvent* expected = log.readNextEvent();
    ASSERT_NE(expected, nullptr);
    EXPECT_EQ(event->number, expected->eventnum);
    EXPECT_EQ(event->utime, expected->timestamp);
    EXPECT_EQ(event->channel, expected->channel);
    const auto* data = static_cast<const std::byte*>(expected->data);
    EXPECT_EQ(event->data, Bytes(data, data + expected->datalen));
    ++count;
  }
  EXPECT_EQ(log.readNextEvent(), nullptr);
  EXPECT_EQ(count, 80);
  EXPECT_FALSE((*reader)->damage().any());
}

TEST_F(EventLog, GoesOnAfterADestroyedSync) {
  const std::vector<size_t> offsets = WriteLog(10);
  Bytes bytes = Load();
  StoreBigEndian(uint32_t{0x12345678}, std::span(bytes).subspan(offsets[4]));
  StoreBigEndian(int64_t{77}, std::span(bytes).subspan(offsets[4] + 4));
  Store(bytes);
  EXPECT_EQ(ReadNumbers(), Range(0, 10, 4));
  EXPECT_EQ(damage.num_places, 1);
  EXPECT_EQ(damage.bytes_skipped, 70);
  EXPECT_EQ(damage.events_lost, 1);
  EXPECT_FALSE(damage.truncated);
  ASSERT_EQ(damage.places.size(), 1U);
  EXPECT_EQ(damage.places[0].Describe(),
            "event 4 at byte 280: no event begins here, 70 bytes skipped");
}

TEST_F(EventLog, MendsAHeaderThatLacksOnlyItsSync) {
  const std::vector<size_t> offsets = WriteLog(10);
  for (const uint32_t sync : {0U, 0xEDA1DA00U, 0xFFFFFFFFU}) {
    WriteLog(10);
    Bytes bytes = Load();
    StoreBigEndian(sync, std::span(bytes).subspan(offsets[4]));
    Store(bytes);
    EXPECT_EQ(ReadNumbers(), Range(0, 10));
    EXPECT_EQ(damage.num_places, 0);
    EXPECT_EQ(damage.events_mended, 1);
    ASSERT_EQ(damage.places.size(), 1U);
    EXPECT_EQ(damage.places[0].Describe(), "event 4 at byte 280: damaged sync, mended");
  }
}

TEST_F(EventLog, GoesOnAfterHostileLengths) {
  for (const int32_t length : {INT32_MAX, -1, INT32_MIN, 41, 300, 1 << 25, 110}) {
    for (const size_t field : {20U, 24U}) {
      const std::vector<size_t> offsets = WriteLog(10);
      Bytes bytes = Load();
      const auto at = std::span(bytes).subspan(offsets[4] + field);
      const int32_t right = LoadBigEndian<int32_t>(at);
      const bool one_bit = std::popcount(static_cast<uint32_t>(right ^ length)) == 1;
      StoreBigEndian(length, at);
      if (field == 24 && length == 110) continue;  // Exactly two events: nothing can tell.
      Store(bytes);
      EXPECT_EQ(ReadNumbers(), Range(0, 10, one_bit ? -1 : 4)) << length << " at " << field;
      EXPECT_EQ(damage.events_lost, one_bit ? 0 : 1);
      EXPECT_EQ(damage.events_mended, one_bit ? 1 : 0);
    }
  }
}

TEST_F(EventLog, SkipsGarbageBetweenEvents) {
  const std::vector<size_t> offsets = WriteLog(10);
  for (const size_t size : {3U, 28U, 1000U, 200'000U}) {
    Rng rng(size);
    WriteLog(10);
    Bytes bytes = Load();
    Bytes garbage(size);
    for (std::byte& each : garbage) each = static_cast<std::byte>(rng.Below(256));
    bytes.insert(
        bytes.begin() + static_cast<std::ptrdiff_t>(offsets[6]), garbage.begin(), garbage.end());
    Store(bytes);
    EXPECT_EQ(ReadNumbers(), Range(0, 10)) << size;
    EXPECT_EQ(damage.bytes_skipped, static_cast<int64_t>(size));
    EXPECT_EQ(damage.events_lost, 0);
  }
}

// What is read can be written again, and LCM can send it.
TEST_F(EventLog, ChannelsThatLcmCannotHaveAreDamage) {
  for (const int32_t length : {64, 255, 256}) {
    const std::vector<size_t> offsets = WriteLog(3);
    Bytes bytes = Load();
    const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(offsets[1]);
    Bytes event(EventHeader::kBytes);
    EventHeader{.number = 1, .utime = 1001, .channel_bytes = length, .data_bytes = 5}.Store(event);
    event.resize(event.size() + static_cast<size_t>(length) + 5, std::byte{'A'});
    bytes.erase(at, at + static_cast<std::ptrdiff_t>(offsets[2] - offsets[1]));
    bytes.insert(
        bytes.begin() + static_cast<std::ptrdiff_t>(offsets[1]), event.begin(), event.end());
    Store(bytes);
    EXPECT_EQ(ReadNumbers(), Range(0, 3, 1)) << length;
    EXPECT_EQ(damage.bytes_skipped, static_cast<int64_t>(event.size()));
    EXPECT_EQ(damage.events_lost, 1);
  }
}

TEST_F(EventLog, CountsEventsThatWereCutOut) {
  const std::vector<size_t> offsets = WriteLog(10);
  Bytes bytes = Load();
  bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(offsets[3] + 10),
              bytes.begin() + static_cast<std::ptrdiff_t>(offsets[7] + 10));
  Store(bytes);
  // Number 7's lengths follow number 3's beginning: one event, under one of the numbers.
  auto reader = EventLogReader::Open(file);
  ASSERT_TRUE(reader.ok());
  int count = 0;
  while ((*reader)->Next()) ++count;
  EXPECT_EQ(count, 6);
}

TEST_F(EventLog, EveryTruncationIsCounted) {
  const std::vector<size_t> offsets = WriteLog(3);
  const Bytes bytes = Load();
  const std::set<size_t> boundaries = {offsets[1], offsets[2], bytes.size()};
  for (size_t size = 4; size <= bytes.size(); ++size) {
    Store(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
    const auto whole = static_cast<int64_t>(size / 70);
    EXPECT_EQ(ReadNumbers(), Range(0, whole)) << size;
    EXPECT_EQ(damage.truncated, !boundaries.contains(size)) << size;
    EXPECT_EQ(damage.bytes_skipped, static_cast<int64_t>(size % 70)) << size;
  }
}

// One flip costs one event at most, and where it lies in a header that is noticed.
TEST_F(EventLog, EveryFlipCostsOneEventAtMost) {
  WriteLog(6);
  const Bytes bytes = Load();
  for (size_t i = 4; i < bytes.size(); ++i) {
    for (const unsigned bit : {0U, 3U, 7U}) {
      Bytes damaged = bytes;
      damaged[i] ^= static_cast<std::byte>(1U << bit);
      Store(damaged);
      auto reader = EventLogReader::Open(file);
      ASSERT_TRUE(reader.ok());
      int unharmed = 0;
      while (const std::optional<LogEvent> event = (*reader)->Next()) {
        unharmed += event->utime == 1000 + event->number && event->channel == "CH" &&
                    event->data == Bytes(40, std::byte(event->number));
      }
      EXPECT_GE(unharmed, 5) << "byte " << i << " bit " << bit;
      const size_t in_event = i % 70;
      const bool in_sync_or_length = in_event < 4 || (in_event >= 20 && in_event < 28);
      EXPECT_EQ((*reader)->damage().any(), in_sync_or_length) << "byte " << i << " bit " << bit;
    }
  }
}

TEST_F(EventLog, RandomBytesAfterASyncDoNoHarm) {
  Rng rng(3);
  for (int round = 0; round < 200; ++round) {
    Bytes bytes;
    for (uint32_t i = rng.Below(40); i < 60; ++i) {
      bytes.resize(bytes.size() + 4);
      const bool sync = bytes.size() == 4 || rng.Below(4) == 0;
      StoreBigEndian(sync ? 0xEDA1DA01U : rng.NextUint32() >> rng.Below(32),
                     std::span(bytes).last(4));
    }
    Store(bytes);
    auto reader = EventLogReader::Open(file);
    ASSERT_TRUE(reader.ok());
    int64_t read = 0;
    while (const std::optional<LogEvent> event = (*reader)->Next()) {
      read += static_cast<int64_t>(28 + event->channel.size() + event->data.size());
    }
    EXPECT_EQ(read + (*reader)->damage().bytes_skipped, static_cast<int64_t>(bytes.size()));
  }
}

TEST_F(EventLog, RefusesWhatIsNoLog) {
  const auto message = [&] {
    const auto reader = EventLogReader::Open(file);
    return reader.ok() ? std::string("opened") : reader.error().message;
  };
  EXPECT_NE(message().find("No such file"), std::string::npos) << message();
  Store({});
  EXPECT_NE(message().find("is no LCM log: it is empty"), std::string::npos) << message();
  Store(Bytes(100, std::byte{'#'}));
  EXPECT_NE(message().find("it starts with 23 23 23 23, expected"), std::string::npos) << message();
  EXPECT_NE(message().find(file.string()), std::string::npos);
  fs::remove(file);
  fs::create_directory(file);
  EXPECT_NE(message().find("no regular file"), std::string::npos) << message();
}

TEST_F(EventLog, LeavesNothingHalfWritten) {
  {
    auto writer = EventLogWriter::Create(file);
    ASSERT_TRUE(writer.ok());
    EXPECT_TRUE((*writer)->Write(1, "CH", Bytes(100)).ok());
    EXPECT_FALSE(fs::exists(file));
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const auto refused = EventLogWriter::Create(folder.path() / "absent" / "test.log");
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("absent/test.log"), std::string::npos);
}

TEST_F(EventLog, WriterRefusesChannelsThatLcmCannotHave) {
  auto writer = EventLogWriter::Create(file);
  ASSERT_TRUE(writer.ok());
  EXPECT_FALSE((*writer)->Write(1, "", {}).ok());
  EXPECT_FALSE((*writer)->Write(1, std::string(64, 'A'), {}).ok());
  EXPECT_TRUE((*writer)->Write(1, std::string(63, 'A'), {}).ok());
}

}  // namespace
}  // namespace vantage
