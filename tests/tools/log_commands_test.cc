// vantage-log info, check, repair, cut, filter and merge, as their users run them.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/log_bus.h"
#include "bus/message_check.h"
#include "tests/tools/run_program.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/log_header_t.hpp"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kStart = 1'700'000'000'000'000;  // us

class LogCommandsTest : public ToolTest {
 protected:
  LogCommandsTest() : ToolTest("vantage-log") {}

  // A header, then seq first to last on A every 0.1 s, with B a millisecond behind each.
  void WriteLog(const std::string& name, int first, int last, int64_t seed = 1) const {
    auto writer = std::move(EventLogWriter::Create(scratch() / name)).value();
    log_header_t header{};
    header.version = "7.8";
    header.seed = seed;
    FillSchemas(&header);
    ASSERT_TRUE(writer->Write(kStart + 100'000 * first, "LOG_HEADER", Encode(header)).ok());
    for (int seq = first; seq <= last; ++seq) {
      arm_status_t status{};
      status.utime = kStart + 100'000 * seq;
      status.seq = seq;
      ASSERT_TRUE(writer->Write(status.utime, "A", Encode(status)).ok());
      const std::vector<std::byte> foreign(8 + static_cast<size_t>(seq), std::byte{0x55});
      ASSERT_TRUE(writer->Write(status.utime + 1000, "B", foreign).ok());
    }
    ASSERT_TRUE(writer->Close().ok());
  }

  [[nodiscard]] std::vector<LogEvent> Read(const std::string& name) const {
    auto reader = std::move(EventLogReader::Open(scratch() / name)).value();
    std::vector<LogEvent> events;
    while (std::optional<LogEvent> event = reader->Next()) events.push_back(*std::move(event));
    EXPECT_FALSE(reader->damage().any());
    return events;
  }

  [[nodiscard]] std::string Bytes(const std::string& name) const {
    std::ifstream stream(scratch() / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  void Store(const std::string& name, const std::string& bytes) const {
    std::ofstream(scratch() / name, std::ios::binary) << bytes;
  }
};

TEST_F(LogCommandsTest, InfoTellsWhatIsThere) {
  WriteLog("a.lcm", 0, 10);
  const ProgramOutput shown = Run("info a.lcm");
  EXPECT_EQ(shown.exit_code, 0);
  for (const char* part : {"23 events",
                           "1.001 s",
                           "2023-11-14 22:13:20.000000 UTC",
                           "written by vantage 7.8, seed 1, configuration unknown",
                           "arm_status_t",
                           "5555555555555555",
                           "damage: none"}) {
    EXPECT_NE(shown.text.find(part), std::string::npos) << part << " in\n" << shown.text;
  }
  const auto json = nlohmann::json::parse(Run("info --json a.lcm").text);
  EXPECT_EQ(json["events"], 23);
  EXPECT_EQ(json["channels"][0]["channel"], "A");
  EXPECT_EQ(json["channels"][0]["lost"], 0);
  EXPECT_TRUE(json["channels"][1]["lost"].is_null());
  EXPECT_EQ(json["channels"][1]["largest_bytes"], 18);
}

TEST_F(LogCommandsTest, CheckAndRepair) {
  WriteLog("a.lcm", 0, 10);
  EXPECT_EQ(Run("check a.lcm").exit_code, 0);
  std::string bytes = Bytes("a.lcm");
  bytes.resize(bytes.size() - 3);
  Store("b.lcm", bytes);
  const ProgramOutput checked = Run("check b.lcm");
  EXPECT_EQ(checked.exit_code, 1);
  EXPECT_NE(checked.text.find("damaged: event 22 at byte"), std::string::npos) << checked.text;
  EXPECT_EQ(Run("repair b.lcm --output c.lcm").exit_code, 0);
  EXPECT_EQ(Bytes("b.lcm"), bytes);
  EXPECT_EQ(Read("c.lcm").size(), 22U);
  EXPECT_EQ(Run("check c.lcm").exit_code, 0);
  ExpectRefused("repair b.lcm --output c.lcm", "c.lcm exists, expected a new name or --force");
  ExpectRefused("repair b.lcm --output b.lcm --force", "is the log that is read");
  EXPECT_EQ(Run("repair a.lcm --output c.lcm --force").exit_code, 0);
  EXPECT_EQ(Bytes("c.lcm"), Bytes("a.lcm"));
}

TEST_F(LogCommandsTest, CutKeepsTheHeaderAtTheFirstTime) {
  WriteLog("a.lcm", 0, 10);
  ASSERT_EQ(Run("cut a.lcm --from 0.2 --to 0.5 --output b.lcm").exit_code, 0);
  const std::vector<LogEvent> events = Read("b.lcm");
  ASSERT_EQ(events.size(), 7U);
  EXPECT_EQ(events[0].channel, "LOG_HEADER");
  EXPECT_EQ(events[0].utime, kStart + 200'000);
  EXPECT_EQ(events[1].utime, kStart + 200'000);
  EXPECT_EQ(events[6].utime, kStart + 401'000);
  ASSERT_EQ(Run("cut a.lcm --from 1700000000200000 --to 1700000000500000 --output c.lcm").exit_code,
            0);
  EXPECT_EQ(Bytes("b.lcm"), Bytes("c.lcm"));
  ExpectRefused("cut a.lcm --from 5 --output d.lcm", "no events from 5 to the end");
  ExpectRefused("cut a.lcm --from 5 --to 5 --output d.lcm", "--from 5 is not before --to 5");
  ExpectRefused("cut a.lcm --output d.lcm", "expected one of them");
}

TEST_F(LogCommandsTest, FilterByChannel) {
  WriteLog("a.lcm", 0, 10);
  ASSERT_EQ(Run("filter a.lcm --channels A --output b.lcm").exit_code, 0);
  EXPECT_EQ(Read("b.lcm").size(), 12U);
  ASSERT_EQ(Run("filter a.lcm --exclude '[A]' --output c.lcm").exit_code, 0);
  EXPECT_EQ(Read("c.lcm").size(), 12U);
  ExpectRefused("filter a.lcm --channels 'A|NOPE' --output d.lcm",
                "has no channel NOPE, expected one of A, B, LOG_HEADER");
  ExpectRefused("filter a.lcm --channels '(' --output d.lcm", "(");
}

TEST_F(LogCommandsTest, MergeOfOverlappingRecordings) {
  WriteLog("all.lcm", 0, 20);
  WriteLog("a.lcm", 0, 12);
  WriteLog("b.lcm", 8, 20, 2);
  const ProgramOutput merged = Run("merge b.lcm a.lcm --drop-duplicates --output m.lcm");
  EXPECT_EQ(merged.exit_code, 0);
  EXPECT_NE(merged.text.find("10 duplicates dropped"), std::string::npos) << merged.text;
  EXPECT_NE(merged.text.find("LOG_HEADER of a.lcm differs from the one kept: seed 2 and 1"),
            std::string::npos)
      << merged.text;
  const std::vector<LogEvent> events = Read("m.lcm");
  const std::vector<LogEvent> expected = Read("all.lcm");
  ASSERT_EQ(events.size(), expected.size());
  for (size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].utime, expected[i].utime);
    EXPECT_EQ(events[i].channel, expected[i].channel);
    EXPECT_EQ(events[i].data == expected[i].data, i > 0) << i;  // The header is b.lcm's.
  }
  ASSERT_EQ(Run("merge a.lcm b.lcm --output n.lcm").exit_code, 0);
  EXPECT_EQ(Read("n.lcm").size(), expected.size() + 10);
  ExpectRefused("merge a.lcm ./a.lcm --output o.lcm", "is named twice");
}

TEST_F(LogCommandsTest, RefusesWhatIsNoLog) {
  Store("empty", "");
  Store("picture.png", "\x89PNG\r\n\x1a\n" + std::string(3000, 'x'));
  fs::create_directory(scratch() / "folder");
  for (const std::string command : {"info ",
                                    "check ",
                                    "repair -o out ",
                                    "cut --from 1 -o out ",
                                    "filter --channels A -o out ",
                                    "merge -o out picture.png "}) {
    ExpectRefused(command + "empty", command[0] == 'm' ? "is no LCM log" : "it is empty");
    ExpectRefused(command + "picture.png", "is no LCM log");
    ExpectRefused(command + "folder", "is no LCM log");
    ExpectRefused(command + "/dev/zero", "is no LCM log");
    if (command[0] != 'm') ExpectRefused(command + "absent", "No such file");
  }
}

TEST_F(LogCommandsTest, TellsAHeaderOfANewerVersion) {
  auto writer = std::move(EventLogWriter::Create(scratch() / "a.lcm")).value();
  ASSERT_TRUE(writer->Write(kStart, "LOG_HEADER", std::vector<std::byte>(90, std::byte{3})).ok());
  ASSERT_TRUE(writer->Close().ok());
  const ProgramOutput shown = Run("info a.lcm");
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_NE(shown.text.find("written by a newer version"), std::string::npos) << shown.text;
}

}  // namespace
}  // namespace vantage
