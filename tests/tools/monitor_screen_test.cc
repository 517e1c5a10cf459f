#include "tools/monitor/monitor_screen.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/monitor_messages.h"
#include "tools/monitor/monitor_json.h"

namespace vantage {
namespace {

MonitorModel MadeModel(int num_processes, int num_channels) {
  MonitorModel model;
  for (int i = 0; i < num_processes; ++i) {
    Send(&model, "PROCESS_STATUS", MadeProcess("proc" + std::to_string(i)), kStart);
  }
  Send(&model, "CAMERA_XTION_STATUS", MadeCamera("XTION"), kStart);
  arm_status_t arm{};
  arm.utime = kStart;
  arm.name = "XTION";
  Send(&model, "ARM_STATUS", arm, kStart);
  for (int i = 0; i < num_channels; ++i) {
    for (int n = 0; n <= i; ++n) {
      model.Add("CH" + std::to_string(100 + i), kStart + n * 1000, std::vector<std::byte>(16));
    }
  }
  return model;
}

TEST(MonitorScreen, FitsScreensOfAllSizes) {
  for (const auto& [processes, channels] : {std::pair{0, 0}, {1, 1}, {4, 12}, {200, 300}}) {
    const MonitorModel model = MadeModel(processes, channels);
    for (const size_t rows : {1U, 2U, 3U, 5U, 10U, 24U, 60U, 500U}) {
      for (const size_t columns : {1U, 20U, 80U, 200U}) {
        for (const bool details : {false, true}) {
          ScreenState state;
          state.shows_process = details;
          state.selected = 150;
          state.first_line = 90;
          const auto lines = DrawScreen(model,
                                        std::vector<std::string>(20, "a problem"),
                                        "log",
                                        state,
                                        {rows, columns},
                                        kStart);
          EXPECT_EQ(lines.size(), rows);
          for (const ScreenLine& line : lines) EXPECT_LE(line.text.size(), columns) << line.text;
        }
      }
    }
  }
}

TEST(MonitorScreen, ShowsTheWholeSetUpOn24LinesOf80) {
  const std::string text =
      TextOf(DrawScreen(MadeModel(5, 3), {}, "udpm://x", {}, {24, 80}, kStart + kSecond));
  for (const char* part : {"vantage-top",
                           "udpm://x",
                           "ok",
                           "proc0",
                           "proc4",
                           "XTION",
                           "streaming",
                           "arm of XTION: resting",
                           "CH100",
                           "CH102",
                           "q quit"}) {
    EXPECT_NE(text.find(part), std::string::npos) << "lacks " << part << "\n" << text;
  }
}

TEST(MonitorScreen, ProblemsComeFirstAndTheRestIsCounted) {
  const auto lines = DrawScreen(
      MadeModel(1, 1), {"one", "two", "three", "four", "five"}, "x", {}, {24, 80}, kStart);
  EXPECT_EQ(lines[1].text, "one");
  EXPECT_EQ(lines[2].text, "two");
  EXPECT_EQ(lines[3].text, "and 3 more");
  EXPECT_EQ(lines[1].style, ScreenLine::Style::kWrong);
}

TEST(MonitorScreen, SortsChannels) {
  const MonitorModel model = MadeModel(1, 5);
  const auto order = [&model](ChannelOrder by) {
    const std::string text = TextOf(DrawSnapshot(model, {}, "x", by, kStart + kSecond));
    return text.find("CH104") < text.find("CH100");
  };
  EXPECT_FALSE(order(ChannelOrder::kName));
  EXPECT_TRUE(order(ChannelOrder::kRate));
  EXPECT_TRUE(order(ChannelOrder::kBandwidth));
  EXPECT_FALSE(order(ChannelOrder::kAge));  // The oldest first.
}

TEST(MonitorScreen, KeysDoWhatTheySay) {
  ScreenState state;
  ApplyKeys("j", 3, &state);
  ApplyKeys("\033[B", 3, &state);
  ApplyKeys("jjjj", 3, &state);
  EXPECT_EQ(state.selected, 2U);
  ApplyKeys("k\033[A\033OAk", 3, &state);
  EXPECT_EQ(state.selected, 0U);
  ApplyKeys("ss", 3, &state);
  EXPECT_EQ(state.order, ChannelOrder::kBandwidth);
  ApplyKeys("ssss", 3, &state);
  EXPECT_EQ(state.order, ChannelOrder::kName);
  ApplyKeys("p", 3, &state);
  EXPECT_TRUE(state.is_paused);
  ApplyKeys(" ", 3, &state);
  EXPECT_FALSE(state.is_paused);
  ApplyKeys("\r", 3, &state);
  EXPECT_TRUE(state.shows_process);
  ApplyKeys("\033[6~", 3, &state);
  EXPECT_EQ(state.first_line, 10U);
  ApplyKeys("\033[5~\033[5~", 3, &state);
  EXPECT_EQ(state.first_line, 0U);
  ApplyKeys("\033", 3, &state);
  EXPECT_FALSE(state.shows_process);
  EXPECT_FALSE(state.wants_to_quit);
  ApplyKeys("q", 3, &state);
  EXPECT_TRUE(state.wants_to_quit);
}

TEST(MonitorScreen, UnknownKeysDoNothing) {
  ScreenState state;
  ApplyKeys(std::string("\033[99;5qzx\0\xff", 11), 0, &state);
  ApplyKeys("\r", 0, &state);  // No process to look at.
  EXPECT_FALSE(state.shows_process || state.wants_to_quit || state.is_paused);
  EXPECT_EQ(state.selected, 0U);
}

TEST(MonitorScreen, NothingOfTheWireSteersTheTerminal) {
  MonitorModel model;
  process_status_t evil = MadeProcess(
      "\033[2Jevil\n\xc2\x9b"
      "1m");
  evil.host = evil.version = evil.config_hash = evil.state = "\033]0;x\007";
  evil.channels[0].channel = evil.stages[0].stage = "\033[5A\r";
  Send(&model, "PROCESS_STATUS", evil, kStart);
  camera_status_v2_t camera = MadeCamera("\033c");
  camera.message = camera.serial = "\033[H";
  Send(&model, "\033[31mCHANNEL", camera, kStart);
  arm_status_t arm{};
  arm.name = arm.reason = "\033[7m";
  Send(&model, "ARM_STATUS", arm, kStart);
  handeye_check_t check{};
  check.camera = check.source = check.reason = "\x80\033[m";
  Send(&model, "HANDEYE_CHECK", check, kStart);
  ScreenState details;
  details.shows_process = true;
  for (const auto& lines : {DrawScreen(model, {}, "\033x", {}, {60, 200}, kStart),
                            DrawScreen(model, {}, "x", details, {60, 200}, kStart),
                            DrawSnapshot(model, {}, "\033x", ChannelOrder::kName, kStart)}) {
    for (const ScreenLine& line : lines) {
      for (const char c : line.text) ASSERT_TRUE(c >= 0x20 && c <= 0x7e) << line.text;
    }
  }
  const std::string json = MonitorJson(model, {"\033"}, kStart);
  for (const char c : json) ASSERT_TRUE((c >= 0x20 && c <= 0x7e) || c == '\n');
  EXPECT_TRUE(nlohmann::json::accept(json));
}

TEST(MonitorJson, SaysWhatTheModelKnows) {
  const auto json =
      nlohmann::json::parse(MonitorJson(MadeModel(2, 3), {"a problem"}, kStart + kSecond));
  EXPECT_EQ(json["ok"], false);
  EXPECT_EQ(json["problems"][0], "a problem");
  ASSERT_EQ(json["processes"].size(), 2U);
  EXPECT_EQ(json["processes"][0]["name"], "proc0");
  EXPECT_EQ(json["processes"][0]["stages"][0]["latency_p99"], 0.03);
  EXPECT_NEAR(json["processes"][0]["age"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(json["cameras"][0]["state"], "streaming");
  EXPECT_EQ(json["arms"][0]["state"], "resting");
  EXPECT_EQ(json["channels"].size(), 6U);
}

}  // namespace
}  // namespace vantage
