// What vantage-log record writes: files that are whole at any time, in parts, each with LOG_HEADER
// first; and what it counts as lost. tests/fault/recording.sh runs the program itself.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "nodes/config_reader.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "tools/log/log_setup.h"
#include "tools/log/loss_counter.h"
#include "tools/log/recording.h"
#include "tools/log/recording_file.h"
#include "tools/support/log_config.h"
#include "tools/support/portable_config.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/process_status_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kStart = 1'700'000'000'000'000;  // us

std::vector<std::byte> Bytes(size_t size, int value) { return {size, std::byte(value)}; }

std::vector<LogEvent> ReadWhole(const fs::path& file) {
  std::vector<LogEvent> events;
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(file);
  EXPECT_TRUE(reader.ok()) << reader.error().message;
  if (!reader) return events;
  while (std::optional<LogEvent> event = (*reader)->Next()) events.push_back(*std::move(event));
  EXPECT_FALSE((*reader)->damage().any());
  return events;
}

class RecordingTest : public ScratchTest {
 protected:
  [[nodiscard]] fs::path file() const { return scratch() / "run.lcm"; }
  [[nodiscard]] RecordingOptions Options() const {
    RecordingOptions options;
    options.file = file();
    options.min_free_bytes = 0;
    return options;
  }
};

TEST_F(RecordingTest, WhatIsFlushedIsThereWhileTheFileIsOpen) {
  auto opened = RecordingFile::Create(file(), false);
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  RecordingFile& recording = **opened;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(recording.Write(kStart + i, "A", Bytes(static_cast<size_t>(i), i)).ok());
  }
  EXPECT_EQ(fs::file_size(file()), 0U);
  ASSERT_TRUE(recording.Flush().ok());
  EXPECT_EQ(fs::file_size(file()), static_cast<uintmax_t>(recording.num_bytes()));
  const std::vector<LogEvent> events = ReadWhole(file());
  ASSERT_EQ(events.size(), 5U);
  for (int i = 0; i < 5; ++i) {
    const LogEvent& event = events[static_cast<size_t>(i)];
    EXPECT_EQ(event.number, i);
    EXPECT_EQ(event.utime, kStart + i);
    EXPECT_EQ(event.channel, "A");
    EXPECT_EQ(event.data, Bytes(static_cast<size_t>(i), i));
  }
}

TEST_F(RecordingTest, AFileHasOneRecordingAtATime) {
  auto first = RecordingFile::Create(file(), false);
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE((*first)->Write(kStart, "A", Bytes(10, 1)).ok());
  ASSERT_TRUE((*first)->Flush().ok());
  const auto size = fs::file_size(file());
  auto second = RecordingFile::Create(file(), false);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find("exists already"), std::string::npos);
  second = RecordingFile::Create(file(), true);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find("another recording"), std::string::npos);
  EXPECT_EQ(fs::file_size(file()), size);
  first.value().reset();
  second = RecordingFile::Create(file(), true);
  ASSERT_TRUE(second.ok()) << second.error().message;
  EXPECT_EQ(fs::file_size(file()), 0U);
}

TEST_F(RecordingTest, AFullDiskLeavesWholeEvents) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  auto opened = RecordingFile::Create(file(), false);
  ASSERT_TRUE(opened.ok());
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE((*opened)->Write(kStart + i, "CHANNEL", Bytes(1000, i)).ok());
  }
  ASSERT_TRUE((*opened)->Flush().ok());
  for (int i = 10; i < 30; ++i) {
    ASSERT_TRUE((*opened)->Write(kStart + i, "CHANNEL", Bytes(1000, i)).ok());
  }
  rlimit limit = before;
  limit.rlim_cur = 20'000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const Result<void> flushed = (*opened)->Flush();
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  ASSERT_FALSE(flushed.ok());
  EXPECT_NE(flushed.error().message.find("File too large"), std::string::npos);
  constexpr int64_t kWhole = 20'000 / (28 + 7 + 1000);
  EXPECT_EQ((*opened)->num_events(), kWhole);
  EXPECT_EQ((*opened)->num_bytes(), kWhole * (28 + 7 + 1000));
  opened.value().reset();
  EXPECT_EQ(ReadWhole(file()).size(), static_cast<size_t>(kWhole));
}

TEST_F(RecordingTest, NoRegularFileIsRefused) {
  for (const char* path : {"/dev/null", "/dev/full", "/tmp", "/nowhere/run.lcm"}) {
    for (const bool overwrite : {false, true}) {
      EXPECT_FALSE(RecordingFile::Create(path, overwrite).ok()) << path;
    }
  }
}

TEST_F(RecordingTest, EveryPartHasAHeaderAndFitsItsBound) {
  RecordingOptions options = Options();
  options.split_bytes = 10'000;
  options.setup = {.config_text = "[x]\ny = 1\n", .seed = 7};
  auto recording = Recording::Start(options, kStart);
  ASSERT_TRUE(recording.ok()) << recording.error().message;
  for (int i = 0; i < 40; ++i) {
    ASSERT_TRUE((*recording)->Write(kStart + i, "A", Bytes(1000, i)).ok());
  }
  ASSERT_TRUE((*recording)->Sync().ok());
  const std::vector<Recording::Part> parts = (*recording)->Parts();
  EXPECT_GT(parts.size(), 4U);
  int next = 0;
  for (const Recording::Part& part : parts) {
    EXPECT_LE(part.num_bytes, options.split_bytes);
    EXPECT_EQ(part.num_bytes, static_cast<int64_t>(fs::file_size(part.file)));
    const std::vector<LogEvent> events = ReadWhole(part.file);
    ASSERT_EQ(static_cast<int64_t>(events.size()), part.num_events);
    ASSERT_EQ(events.front().channel, "LOG_HEADER");
    const Result<log_header_t> header = DecodeChecked<log_header_t>(events.front().data);
    ASSERT_TRUE(header.ok()) << header.error().message;
    EXPECT_EQ(header->config_text, options.setup.config_text);
    EXPECT_EQ(header->seed, 7);
    EXPECT_EQ(header->utime, events.front().utime);
    for (size_t i = 1; i < events.size(); ++i) EXPECT_EQ(events[i].data, Bytes(1000, next++));
  }
  EXPECT_EQ(next, 40);
  EXPECT_EQ(parts.front().file.filename(), "run-000.lcm");
  EXPECT_FALSE(Recording::Start(options, kStart).ok());
}

TEST_F(RecordingTest, PartsOfAnEarlierRecordingAreNotMixedIn) {
  ASSERT_TRUE(WriteFileBytes(scratch() / "run-001.lcm", "x").ok());
  RecordingOptions options = Options();
  options.split_us = 1'000'000;
  const auto refused = Recording::Start(options, kStart);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("run-001.lcm exists already"), std::string::npos);
  EXPECT_EQ(ListTree(scratch()).size(), 1U);
}

TEST_F(RecordingTest, PartsEndByTime) {
  RecordingOptions options = Options();
  options.split_us = 1'000'000;
  auto recording = Recording::Start(options, kStart);
  ASSERT_TRUE(recording.ok());
  for (int i = 0; i < 35; ++i) {
    ASSERT_TRUE((*recording)->Write(kStart + 100'000 * i, "A", Bytes(1, i)).ok());
  }
  EXPECT_EQ((*recording)->Parts().size(), 4U);
}

TEST_F(RecordingTest, FilesInAFolderAreNamedAfterTheirStart) {
  RecordingOptions options = Options();
  options.file.clear();
  options.folder = scratch() / "logs";
  const auto first = Recording::Start(options, kStart);
  ASSERT_TRUE(first.ok()) << first.error().message;
  const auto second = Recording::Start(options, kStart);
  ASSERT_TRUE(second.ok()) << second.error().message;
  EXPECT_EQ((*first)->path().filename(), "2023-11-14T22-13-20Z.lcm");
  EXPECT_EQ((*second)->path().filename(), "2023-11-14T22-13-20Z-2.lcm");
}

TEST_F(RecordingTest, AFullDiskIsNotBegunOn) {
  RecordingOptions options = Options();
  options.min_free_bytes = int64_t{1} << 60;
  const auto refused = Recording::Start(options, kStart);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("--min-free-mb"), std::string::npos);
  EXPECT_TRUE(ListTree(scratch()).empty());
}

TEST_F(RecordingTest, ALogIsReadWithItsOwnConfigurationWhereverItLies) {
  fs::create_directories(scratch() / "setup");
  const fs::path config = scratch() / "setup" / "a.toml";
  ASSERT_TRUE(
      WriteFileBytes(config, "[models]\nfolder = \"../models\" # here\n[ppf]\nseed = 5\n").ok());
  const Result<LogSetup> setup = ReadLogSetup(config);
  ASSERT_TRUE(setup.ok()) << setup.error().message;
  EXPECT_EQ(setup->seed, 5);
  RecordingOptions options = Options();
  options.setup = *setup;
  { ASSERT_TRUE(Recording::Start(options, kStart).ok()); }
  Result<ConfigReader> read = OpenConfig("", file());
  ASSERT_TRUE(read.ok()) << read.error().message;
  fs::path folder;
  read->Root().Sub("models").ReadPath("folder", &folder);
  EXPECT_EQ(folder, scratch() / "models");
  EXPECT_NE(read->text().find("# here"), std::string::npos);
  EXPECT_FALSE(ReadLogSetup(scratch() / "none.toml").ok());
}

TEST(PortableConfig, OnlyPathsChange) {
  const std::string text =
      "# ü models.folder = \"no\"\n"
      "[camera.\"Käm\"]\n"
      "device = 'oni:rec/a.oni'   # \"x\"\n"
      "calibration = \"/abs/c.toml\"\n"
      "[camera.B]\n"
      "device = \"serial:SIM\"\n"
      "models = {use = [\"ü\"], folder = \"m\"}\n"
      "[confusion]\n"
      "tables = {mug = \"t/mug.bin\", bunny = \"none\"}\n"
      "[models]\n"
      "folder = \"../m\"\n"
      "[fusion]\n"
      "state_file = \"\"\n";
  const std::string expected =
      "# ü models.folder = \"no\"\n"
      "[camera.\"Käm\"]\n"
      "device = 'oni:/set/up/rec/a.oni'   # \"x\"\n"
      "calibration = \"/abs/c.toml\"\n"
      "[camera.B]\n"
      "device = \"serial:SIM\"\n"
      "models = {use = [\"ü\"], folder = \"m\"}\n"
      "[confusion]\n"
      "tables = {mug = '/set/up/t/mug.bin', bunny = \"none\"}\n"
      "[models]\n"
      "folder = '/set/m'\n"
      "[fusion]\n"
      "state_file = \"\"\n";
  const Result<std::string> portable = PortableConfigText(text, "/set/up");
  ASSERT_TRUE(portable.ok()) << portable.error().message;
  EXPECT_EQ(*portable, expected);
  EXPECT_EQ(*PortableConfigText(*portable, "/elsewhere"), *portable);
  EXPECT_FALSE(PortableConfigText("a = = 1", "/").ok());
}

// A path that a process learns to read must be known here too.
TEST(PortableConfig, KnowsEveryPathThatProcessesRead) {
  std::vector<std::string> keys;
  for (const auto& entry : fs::directory_iterator(fs::path(VANTAGE_SOURCE_DIR) / "nodes")) {
    if (entry.path().filename().string().find("_config.cc") == std::string::npos) continue;
    const Result<std::string> text = ReadFileBytes(entry.path(), 1U << 20U);
    ASSERT_TRUE(text.ok());
    const std::string call = "ReadPath(\"";
    for (size_t at = text->find(call); at != std::string::npos; at = text->find(call, at + 1)) {
      const size_t begin = at + call.size();
      keys.push_back(text->substr(begin, text->find('"', begin) - begin));
    }
  }
  EXPECT_GE(keys.size(), 5U);
  for (const std::string& key : keys) {
    bool known = false;
    for (const char* table : {"camera.X", "models", "fusion", "extrinsics", "up"}) {
      const std::string text = std::string("[") + table + "]\n" + key + " = \"a/b\"\n";
      known = known || *PortableConfigText(text, "/f") != text;
    }
    EXPECT_TRUE(known) << key;
  }
}

process_status_t Status(const std::string& name, int64_t seq) {
  process_status_t status{};
  status.utime = kStart;
  status.seq = seq;
  status.name = name;
  return status;
}

TEST(LossCounter, GapsAndOverrunsAreCountedByChannelAndSender) {
  LossCounter losses;
  EXPECT_EQ(losses.Describe(), "ok");
  for (const int64_t seq : {1, 2, 5}) losses.Add("PROCESS_STATUS", Encode(Status("a", seq)), 0);
  for (const int64_t seq : {100, 101}) losses.Add("PROCESS_STATUS", Encode(Status("b", seq)), 0);
  EXPECT_EQ(losses.total(), 2);
  for (const int64_t seq : {0, 4}) {
    const std::vector<uint16_t> depth(6, 1);
    losses.Add("CAMERA_A",
               Encode(DepthToMessage(3, 2, depth, kStart, seq, "", DepthCompression::kVdc)),
               seq == 4 ? 1 : 0);
  }
  losses.Add("POSES", Encode(rigid_transform_t{}), 3);
  losses.Add("FOREIGN", Bytes(3, 1), 0);
  losses.AddUnfit("FOREIGN");
  EXPECT_EQ(losses.total(), 2 + 3 + 3 + 1);
  EXPECT_EQ(losses.losses().at("CAMERA_A").by_seq, 2);
  EXPECT_EQ(losses.losses().at("CAMERA_A").overrun, 1);
  EXPECT_EQ(losses.losses().at("POSES").overrun, 3);
  EXPECT_EQ(losses.Describe(),
            "9 messages lost (4 never arrived, 4 came faster than the disk took them, 1 too "
            "long): 3 of CAMERA_A, 1 of FOREIGN, 3 of POSES, 2 of PROCESS_STATUS");
}

TEST(LossCounter, HostileChannelsTakeBoundedMemory) {
  LossCounter losses;
  for (int i = 0; i < 5000; ++i) losses.AddUnfit(Format("C%d", i));
  EXPECT_LE(losses.losses().size(), LossCounter::kMaxChannels + 1);
  EXPECT_EQ(losses.total(), 5000);
}

}  // namespace
}  // namespace vantage
