// What top makes of the messages on a bus: no terminal, no network, times passed in.
#include "tools/monitor/monitor_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "tests/tools/monitor_messages.h"
#include "tools/monitor/monitor_json.h"
#include "tools/monitor/monitor_screen.h"
#include "tools/monitor/shown_text.h"
#include "vantage/images_t.hpp"

namespace vantage {
namespace {

TEST(ArrivalStatistics, RateAndBandwidthAreThoseOfARegularSender) {
  ArrivalStatistics arrivals;
  for (int i = 0; i < 100; ++i) arrivals.Add(kStart + i * 50'000, 1000);
  const int64_t now = kStart + 99 * 50'000;
  EXPECT_NEAR(arrivals.Rate(now), 20.0, 1e-9);
  EXPECT_NEAR(arrivals.Bandwidth(now), 20'000.0, 1e-6);
  EXPECT_NEAR(arrivals.Jitter(), 0.0, 1e-12);
  // Between two messages it stays; in silence it falls, and after the window it is nothing.
  EXPECT_NEAR(arrivals.Rate(now + 60'000), 20.0, 1e-9);
  EXPECT_LT(arrivals.Rate(now + 2'000'000), 15.0);
  EXPECT_EQ(arrivals.Rate(now + 6'000'000), 0.0);
}

TEST(ArrivalStatistics, JitterIsTheDeviationOfIntervals) {
  ArrivalStatistics arrivals;
  // Intervals of 40 and 60 ms in turn: 10 ms off their mean.
  int64_t utime = kStart;
  for (int i = 0; i < 80; ++i) arrivals.Add(utime += (i % 2 == 0 ? 40'000 : 60'000), 1);
  EXPECT_NEAR(arrivals.Jitter(), 0.010, 2e-4);
}

TEST(ArrivalStatistics, ClockSetBackBeginsAnew) {
  ArrivalStatistics arrivals;
  for (int i = 0; i < 10; ++i) arrivals.Add(kStart + i * 100'000, 1);
  arrivals.Add(kStart - 3'600'000'000, 1);
  EXPECT_EQ(arrivals.Rate(kStart - 3'600'000'000), 0.0);
  EXPECT_EQ(arrivals.Jitter(), 0.0);
}

TEST(ArrivalStatistics, MessagesAtOneTimeGiveAFiniteRate) {
  ArrivalStatistics arrivals;
  for (int i = 0; i < 50; ++i) arrivals.Add(kStart, 1);
  EXPECT_NEAR(arrivals.Rate(kStart), 10.0, 1e-9);
}

TEST(MonitorModel, KnowsTypesLossesAndMalformedMessages) {
  MonitorModel model;
  for (const int64_t seq : {1, 2, 5, 6}) {
    arm_status_t arm{};
    arm.utime = kStart;
    arm.seq = seq;
    arm.name = "XTION";
    Send(&model, "ARM_STATUS", arm, kStart + seq * 100'000);
  }
  std::vector<std::byte> cut = Encode(MadeProcess("ppf"));
  cut.resize(cut.size() - 3);
  model.Add("PROCESS_STATUS", kStart, cut);
  model.Add("FOREIGN", kStart, std::vector<std::byte>(40, std::byte{7}));
  model.Add("SHORT", kStart, std::vector<std::byte>(3));
  EXPECT_EQ(model.channels().at("ARM_STATUS").type, "arm_status_t");
  EXPECT_EQ(model.channels().at("ARM_STATUS").num_lost, 2);
  EXPECT_EQ(model.channels().at("PROCESS_STATUS").num_malformed, 1);
  EXPECT_EQ(model.channels().at("FOREIGN").type, "0707070707070707");
  EXPECT_EQ(model.channels().at("SHORT").type, "(too short)");
  EXPECT_TRUE(model.processes().empty());
}

TEST(MonitorModel, CountsImagesLostByTheirMetadata) {
  MonitorModel model;
  for (const int64_t seq : {10, 11, 15}) {
    image_t image{};
    AppendIdentity(seq, "S", &image);
    images_t message{};
    AppendImage(images_t::DEPTH_MM, image, &message);
    Send(&model, "CAMERA_X", message, kStart + seq);
  }
  EXPECT_EQ(model.channels().at("CAMERA_X").num_lost, 3);
}

TEST(MonitorModel, CountsOnlyLossesOfTheWatch) {
  MonitorModel model;
  process_status_t status = MadeProcess("ppf");
  status.channels[0].num_lost = 100;  // Before anyone watched.
  Send(&model, "PROCESS_STATUS", status, kStart);
  status.seq = 2;
  status.channels[0].num_lost = 103;
  Send(&model, "PROCESS_STATUS", status, kStart + kSecond);
  EXPECT_EQ(model.processes().at("ppf").losses.at("CAMERA_XTION").lost, 3);
  // Started anew, it counts from 0.
  status.seq = 1;
  status.pid = 7;
  status.start_utime = kStart + kSecond;
  status.channels[0].num_lost = 2;
  Send(&model, "PROCESS_STATUS", status, kStart + 2 * kSecond);
  const SeenProcess& seen = model.processes().at("ppf");
  EXPECT_EQ(seen.losses.at("CAMERA_XTION").lost, 5);
  EXPECT_EQ(seen.num_restarts, 1);
  EXPECT_EQ(seen.num_conflicts, 0);
}

TEST(MonitorModel, CountsAllLossesOfAProcessThatStartsDuringTheWatch) {
  MonitorModel model;
  Send(&model, "PROCESS_STATUS", MadeProcess("fusion"), kStart);
  process_status_t late = MadeProcess("ppf");
  late.start_utime = kStart + kSecond;
  late.channels[0].num_lost = 4;
  Send(&model, "PROCESS_STATUS", late, kStart + 3 * kSecond);
  EXPECT_EQ(model.processes().at("ppf").losses.at("CAMERA_XTION").lost, 4);
}

TEST(MonitorModel, TellsTwoProcessesOfOneNameFromARestart) {
  MonitorModel model;
  for (int i = 0; i < 6; ++i) {
    process_status_t status = MadeProcess("ppf");
    status.pid = 100 + i % 2;
    status.start_utime = kStart - (i % 2) * kSecond;
    Send(&model, "PROCESS_STATUS", status, kStart + i * kSecond / 2);
  }
  EXPECT_GT(model.processes().at("ppf").num_conflicts, 0);
}

TEST(MonitorModel, CommonConfigIsThatOfTheMostProcesses) {
  MonitorModel model;
  for (const char* name : {"a", "b", "c", "progress", "top"}) {
    process_status_t status = MadeProcess(name);
    status.config_hash = std::string(name) == "b" || IsWatcher(name) ? "2222" : "1111";
    Send(&model, "PROCESS_STATUS", status, kStart);
  }
  EXPECT_EQ(model.CommonConfigHash(), "1111");
}

TEST(MonitorModel, BoundsWhatItKeeps) {
  MonitorModel model;
  for (int i = 0; i < 10'000; ++i) {
    const std::string name = Format("p%d", i);
    Send(&model, "PROCESS_STATUS", MadeProcess(name), kStart + i);
    Send(&model, Format("CHANNEL_%d", i), MadeCamera(name), kStart + i);
  }
  process_status_t large = MadeProcess("p0");
  for (int i = 0; i < 10'000; ++i) {
    channel_status_t channel{};
    channel.channel = std::string(10'000, 'x') + std::to_string(i);
    if (i < 1000) large.channels.push_back(channel);
    stage_status_t stage{};
    stage.stage = std::to_string(i);
    large.stages.push_back(stage);
  }
  large.num_channels = static_cast<int32_t>(large.channels.size());
  large.num_stages = static_cast<int32_t>(large.stages.size());
  large.state = std::string(1'000'000, 'y');
  Send(&model, "PROCESS_STATUS", large, kStart + 20'000);
  EXPECT_EQ(model.processes().size(), MonitorModel::kMaxProcesses);
  EXPECT_EQ(model.channels().size(), MonitorModel::kMaxChannels);
  EXPECT_EQ(model.cameras().size(), MonitorModel::kMaxDevices);
  EXPECT_GT(model.num_not_kept(), 0);
  const process_status_t& kept = model.processes().at("p0").status;
  EXPECT_EQ(kept.channels.size(), MonitorModel::kMaxOfProcess);
  EXPECT_EQ(kept.stages.size(), MonitorModel::kMaxOfProcess);
  EXPECT_LE(kept.channels.back().channel.size(), 200U);
  EXPECT_LE(kept.state.size(), 200U);
}

TEST(MonitorModel, ExtremeNumbersDoNoHarm) {
  MonitorModel model;
  constexpr int64_t kLeast = std::numeric_limits<int64_t>::min();
  constexpr int64_t kMost = std::numeric_limits<int64_t>::max();
  for (const int64_t extreme : {kLeast, int64_t{-1}, kMost, kLeast, kMost}) {
    process_status_t status = MadeProcess("ppf");
    status.seq = extreme;
    status.start_utime = extreme;
    status.pid = extreme < 0 ? -1 : 5;
    for (channel_status_t& channel : status.channels) {
      channel.num_received = channel.num_lost = channel.num_overwritten = extreme;
      channel.num_decode_errors = extreme;
      channel.age = channel.rate = std::nan("");
    }
    for (stage_status_t& stage : status.stages) {
      stage.num_runs = extreme;
      stage.latency_p50 = stage.latency_p99 = std::numeric_limits<double>::infinity();
      stage.latency_max = std::nan("");
    }
    Send(&model, "PROCESS_STATUS", status, kStart);
    camera_status_v2_t camera = MadeCamera("XTION");
    camera.state = -128;
    camera.num_captured = camera.num_missed = camera.num_dropped = extreme;
    camera.fps = camera.latency = camera.clock_offset = std::nan("");
    Send(&model, "CAMERA_XTION_STATUS", camera, kStart);
    Send(&model, "CAMERA_XTION_STATUS", camera, extreme);  // As a damaged log may say.
  }
  const std::string text = TextOf(DrawSnapshot(model, {}, "x", ChannelOrder::kName, kStart));
  EXPECT_EQ(text.find("nan"), std::string::npos) << text;
  const std::string json = MonitorJson(model, {}, kStart);
  EXPECT_EQ(json.find("nan"), std::string::npos) << json;
}

TEST(ShownText, NothingSteersATerminal) {
  EXPECT_EQ(Shown("a\033[31mb\r\n\x07\x7f\xc2\x9b"), "a?[31mb??????");
  EXPECT_EQ(Shown("abcdef", 4), "abc~");
  EXPECT_EQ(Shown("abcd", 4), "abcd");
  EXPECT_EQ(Shown("", 0), "");
  EXPECT_EQ(Padded("ab", 4), "ab  ");
}

TEST(ShownText, NumbersFitTheirColumns) {
  for (const double value : {0.0, 0.04, 9.94, 9.96, 99.96, 12345.6, 999999.0, 1e7, 1e300, -5.0}) {
    EXPECT_LE(NumberText(value).size(), 6U) << value;
    EXPECT_LE(LatencyText(value).size(), 8U) << value;
    EXPECT_LE(ScaledText(std::abs(value)).size(), 8U) << value;
  }
  EXPECT_EQ(NumberText(std::nan("")), "-");
  EXPECT_EQ(LatencyText(0.0123), "12 ms");
  EXPECT_EQ(LatencyText(0.000023), "23 us");
  EXPECT_EQ(LatencyText(0.0), "0.0 ms");
  EXPECT_EQ(LatencyText(1.24), "1.2 s");
  EXPECT_EQ(ScaledText(4194304), "4.2 M");
  EXPECT_EQ(DurationText(3725), "1:02:05");
  EXPECT_EQ(DurationText(-1), "-");
  EXPECT_EQ(DurationText(std::nan("")), "-");
  EXPECT_EQ(DurationText(3 * 86400 + 3660), "3d01:01");
}

}  // namespace
}  // namespace vantage
