#include "tools/replay/replay_run.h"

#include <gtest/gtest.h>

#include <thread>

#include "bus/conversions.h"
#include "nodes/handeye_file.h"
#include "tests/tools/replay_logs.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

class ReplayRun : public ScratchTest {
 protected:
  void ExpectSameForAnyThreads(ReplayOptions options) {
    options.cache = cache;
    std::string sequential;
    for (const int threads : {1, 2, 4}) {
      options.threads = threads;
      options.output = scratch() / "out.lcm";
      const Result<ReplaySummary> summary = RunReplay(options);
      ASSERT_TRUE(summary.ok()) << summary.error().message;
      const std::string bytes = FileBytes(options.output);
      if (threads == 1) sequential = bytes;
      EXPECT_GT(bytes.size(), 10'000U);
      EXPECT_TRUE(bytes == sequential) << threads << " threads";
    }
  }
  void ExpectError(const ReplayOptions& options, const std::string& part) const {
    SCOPED_TRACE(part);
    const auto before = ListTree(scratch());
    const Result<ReplaySummary> summary = RunReplay(options);
    ASSERT_FALSE(summary.ok());
    EXPECT_NE(summary.error().message.find(part), std::string::npos) << summary.error().message;
    EXPECT_EQ(ListTree(scratch()), before);
  }
  static std::shared_ptr<EstimatorCache> cache;  // SHOT trains for a while.
};
std::shared_ptr<EstimatorCache> ReplayRun::cache = std::make_shared<EstimatorCache>();

TEST_F(ReplayRun, OutputIsTheSameForAnyNumberOfThreads) {
  const LogEvents events = CameraRun(scratch());
  WriteEvents(events, scratch() / "in.lcm");
  ReplayOptions options = RunOptions(scratch() / "in.lcm", "");
  ExpectSameForAnyThreads(options);
  EXPECT_EQ(MessagesOn("DETECTIONS_PPF", ReadEvents(scratch() / "out.lcm")).size(), 21U);
  options.with_inputs = true;
  ExpectSameForAnyThreads(options);
}

TEST_F(ReplayRun, OutputIsTheSameForAnyNumberOfThreadsAndEstimators) {
  RenderedRun(scratch()).WriteInputs(scratch() / "in.lcm", "");
  ReplayOptions options = RunOptions(scratch() / "in.lcm", "");
  options.estimators = {"shot"};
  ExpectSameForAnyThreads(options);
  EXPECT_EQ(MessagesOn("DETECTIONS_SHOT", ReadEvents(scratch() / "out.lcm")).size(), 3U);
  options.estimators = {"ppf", "shot"};
  ExpectSameForAnyThreads(options);
  EXPECT_EQ(MessagesOn("DETECTIONS_SHOT", ReadEvents(scratch() / "out.lcm")).size(), 3U);
  EXPECT_EQ(MessagesOn("DETECTIONS_PPF", ReadEvents(scratch() / "out.lcm")).size(), 3U);
}

TEST_F(ReplayRun, OutputIsTheSameForAnyNumberOfThreadsWithPosesAnew) {
  // The hand is where the camera is.
  LogEvents events = CameraRun(scratch());
  for (LogEvent& event : events) {
    if (event.channel == "CAMERA_TEST_TO_WORLD") event.channel = "HAND_TO_BASE";
  }
  WriteEvents(events, scratch() / "in.lcm");
  HandEyeFile calibration;
  calibration.camera = "TEST";
  calibration.num_views = 10;
  calibration.covariance = 1e-8 * HandEyeCovariance::Identity();
  calibration.target_covariance = calibration.covariance;
  ASSERT_TRUE(WriteHandEyeFile(calibration, scratch() / "hand-eye.toml").ok());
  ReplayOptions options = RunOptions(scratch() / "in.lcm", "");
  options.with_extrinsics = true;
  const std::string text = RenderedRun::Config() +
                           "[extrinsics]\ncamera = \"TEST\"\ncalibration = \"" +
                           (scratch() / "hand-eye.toml").string() + "\"\n";
  options.open_config = [&text] { return ConfigReader::Parse(text, "setup.toml"); };
  ExpectSameForAnyThreads(options);
  const LogEvents output = ReadEvents(scratch() / "out.lcm");
  EXPECT_EQ(MessagesOn("DETECTIONS_PPF", output).size(), 21U);
  EXPECT_EQ(MessagesOn("CAMERA_TEST_TO_WORLD", output).size(), 3U * 81U);
}

TEST_F(ReplayRun, DamagedLogsAreTheSameForAnyNumberOfThreads) {
  WriteEvents(CameraRun(scratch()), scratch() / "in.lcm");
  std::string bytes = FileBytes(scratch() / "in.lcm");
  for (size_t at = 5000; at < bytes.size(); at += bytes.size() / 7) {
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), 60, '\x5a');
  }
  bytes.resize(bytes.size() - 100);
  ASSERT_TRUE(WriteFileBytes(scratch() / "in.lcm", bytes).ok());
  ReplayOptions options = RunOptions(scratch() / "in.lcm", "");
  ExpectSameForAnyThreads(options);
  options.threads = 4;
  const Result<ReplaySummary> summary = RunReplay(options);
  ASSERT_TRUE(summary.ok()) << summary.error().message;
  EXPECT_TRUE(summary->damage.any());
}

TEST_F(ReplayRun, RerunsMayGoOnBesideEachOther) {
  WriteEvents(CameraRun(scratch()), scratch() / "in.lcm");
  std::vector<std::jthread> threads;
  const auto shared = std::make_shared<EstimatorCache>();
  for (int i = 0; i < 3; ++i) {
    threads.emplace_back([this, i, &shared] {
      ReplayOptions options =
          RunOptions(scratch() / "in.lcm", scratch() / ("out" + std::to_string(i)));
      options.cache = shared;
      options.threads = 1 + i % 2;
      EXPECT_TRUE(RunReplay(options).ok());
    });
  }
  threads.clear();
  EXPECT_TRUE(FileBytes(scratch() / "out0") == FileBytes(scratch() / "out1"));
  EXPECT_TRUE(FileBytes(scratch() / "out0") == FileBytes(scratch() / "out2"));
}

TEST_F(ReplayRun, ReadsPartsOfALog) {
  WriteEvents(CameraRun(scratch()), scratch() / "in.lcm");
  ReplayOptions options = RunOptions(scratch() / "in.lcm", scratch() / "out.lcm");
  const auto count = [&] {
    const Result<ReplaySummary> summary = RunReplay(options);
    EXPECT_TRUE(summary.ok()) << summary.error().message;
    return MessagesOn("DETECTIONS_PPF", ReadEvents(scratch() / "out.lcm")).size();
  };
  // The log begins 0.5 s before the first place's middle; places are 1 s apart.
  options.from = "1.05";
  EXPECT_EQ(count(), 14U);
  options.to = "2.0";
  EXPECT_EQ(count(), 7U);
  options.from = std::to_string(RenderedRun::UtimeOf(1) - 450'000);
  options.to = std::to_string(RenderedRun::UtimeOf(2) + 450'000);
  EXPECT_EQ(count(), 14U);
  options.from = "";
  options.to = "";
  options.channels = "CAMERA_TEST|CAMERA_TEST_INFO";
  EXPECT_EQ(count(), 0U) << "no poses";
  options.channels = "CAMERA_.*";
  EXPECT_EQ(count(), 21U);
}

TEST_F(ReplayRun, EventsOutOfOrderGiveTheSameOutput) {
  LogEvents events = CameraRun(scratch());
  WriteEvents(events, scratch() / "in.lcm");
  ReplayOptions options = RunOptions(scratch() / "in.lcm", scratch() / "out.lcm");
  ASSERT_TRUE(RunReplay(options).ok());
  const std::string expected = FileBytes(scratch() / "out.lcm");
  // Poses were recorded elsewhere and come 0.6 s behind the rest.
  LogEvents late;
  for (const LogEvent& event : events) {
    if (event.channel == "CAMERA_TEST_TO_WORLD") late.push_back(event);
  }
  std::erase_if(events,
                [](const LogEvent& event) { return event.channel == "CAMERA_TEST_TO_WORLD"; });
  LogEvents mixed;
  size_t next = 0;
  for (const LogEvent& event : events) {
    while (next < late.size() && late[next].utime + 600'000 < event.utime) {
      mixed.push_back(late[next++]);
    }
    mixed.push_back(event);
  }
  mixed.insert(mixed.end(), late.begin() + static_cast<std::ptrdiff_t>(next), late.end());
  WriteEvents(mixed, scratch() / "in.lcm");
  const Result<ReplaySummary> summary = RunReplay(options);
  ASSERT_TRUE(summary.ok()) << summary.error().message;
  EXPECT_TRUE(summary->warnings.empty()) << summary->warnings[0];
  EXPECT_TRUE(FileBytes(scratch() / "out.lcm") == expected);
}

TEST_F(ReplayRun, TellsWhenALogBeginsAgain) {
  LogEvents events = CameraRun(scratch());
  const LogEvents once = events;
  events.insert(events.end(), once.begin(), once.end());
  WriteEvents(events, scratch() / "in.lcm");
  const Result<ReplaySummary> summary =
      RunReplay(RunOptions(scratch() / "in.lcm", scratch() / "out.lcm"));
  ASSERT_TRUE(summary.ok()) << summary.error().message;
  ASSERT_EQ(summary->warnings.size(), 1U);
  EXPECT_NE(summary->warnings[0].find("goes back 1 times"), std::string::npos)
      << summary->warnings[0];
  EXPECT_NE(summary->warnings[0].find("event " + std::to_string(once.size())), std::string::npos)
      << summary->warnings[0];
}

TEST_F(ReplayRun, BadInputIsAnErrorAndLeavesNothing) {
  WriteEvents(CameraRun(scratch()), scratch() / "in.lcm");
  const ReplayOptions good = RunOptions(scratch() / "in.lcm", scratch() / "out.lcm");
  const auto with = [&](auto change) {
    ReplayOptions options = good;
    options.threads = 3;
    change(&options);
    return options;
  };
  using Options = ReplayOptions*;
  ExpectError(with([](Options o) { o->threads = 0; }), "--threads is 0");
  ExpectError(with([](Options o) { o->threads = 1000; }), "--threads is 1000");
  ExpectError(with([](Options o) { o->estimators = {"ppf", "ppf"}; }), "names ppf twice");
  ExpectError(with([](Options o) { o->channels = "A("; }), "A(");
  ExpectError(with([](Options o) { o->channels = "CAMERA"; }),
              "of these channels: CAMERA_TEST, CAMERA_TEST_INFO, CAMERA_TEST_TO_WORLD, LOG_HEADER");
  ExpectError(with([](Options o) { o->from = "soon"; }), "--from is 'soon'");
  ExpectError(with([](Options o) { o->to = "-1"; }), "--to is '-1'");
  ExpectError(with([](Options o) { o->from = "nan"; }), "--from is 'nan'");
  ExpectError(with([](Options o) { o->from = "1e300"; }), "--from is '1e300'");
  ExpectError(with([](Options o) { o->from = "2", o->to = "1"; }), "--from 2 is after --to 1");
  ExpectError(with([](Options o) { o->from = "60"; }), "--from 60");
  ExpectError(with([](Options o) { o->to = "1000000000000"; }), "--to 1000000000000");
  ExpectError(with([](Options o) { o->log += ".absent"; }), "in.lcm.absent");
  ExpectError(with([](Options o) { o->output = "/nowhere/out.lcm"; }), "/nowhere/out.lcm");
  ExpectError(with([](Options o) { o->as_received = true; }), "no DETECTIONS_PPF");
  ExpectError(with([](Options o) { o->with_extrinsics = true; }), "extrinsics: missing");
  ASSERT_TRUE(WriteFileBytes(scratch() / "empty.lcm", "").ok());
  ExpectError(with([&](Options o) { o->log = scratch() / "empty.lcm"; }), "it is empty");
  ExpectError(with([](Options o) {
                o->open_config = [] {
                  return ConfigReader::Parse("[models]\nfolder = \"/nowhere\"\n[camera.TEST]\n",
                                             "bad.toml");
                };
              }),
              "/nowhere");
}

}  // namespace
}  // namespace vantage
