// What `vantage-top --check` finds wrong: each fault by itself, against a set-up that is well.
#include "tools/monitor/monitor_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/tools/monitor_messages.h"

namespace vantage {
namespace {

const ExpectedSetup kExpected = {
    .processes = {"fusion", "ppf"}, .cameras = {"XTION"}, .config_hash = "3a02334f5b6c7d8e"};

// A set-up that is watched for some seconds. What each second sends can be changed.
struct Watch {
  std::function<void(int second, process_status_t* ppf)> change_ppf = [](int, process_status_t*) {};
  std::function<void(int second, camera_status_v2_t* camera)> change_camera =
      [](int, camera_status_v2_t*) {};
  std::function<void(MonitorModel*)> add = [](MonitorModel*) {};
  int ppf_ends = 10;     // s
  int camera_ends = 10;  // s

  [[nodiscard]] std::vector<std::string> Problems(const ExpectedSetup& expected = kExpected,
                                                  const MonitorLimits& limits = {}) const {
    MonitorModel model;
    for (int second = 0; second < 10; ++second) {
      const int64_t now = kStart + second * kSecond;
      process_status_t ppf = MadeProcess("ppf");
      ppf.seq = second;
      process_status_t fusion = MadeProcess("fusion");
      fusion.seq = second;
      change_ppf(second, &ppf);
      camera_status_v2_t camera = MadeCamera("XTION");
      camera.seq = second;
      camera.num_captured += 30 * second;
      change_camera(second, &camera);
      if (second < ppf_ends) Send(&model, "PROCESS_STATUS", ppf, now);
      Send(&model, "PROCESS_STATUS", fusion, now);
      if (second < camera_ends) Send(&model, "CAMERA_XTION_STATUS", camera, now);
    }
    add(&model);
    return FindProblems(model, expected, limits, kStart + 10 * kSecond);
  }
};

// Exactly one problem, which has all the parts.
void ExpectOne(const std::vector<std::string>& problems, const std::vector<std::string>& parts) {
  ASSERT_EQ(problems.size(), 1U) << ::testing::PrintToString(problems);
  for (const std::string& part : parts) {
    EXPECT_NE(problems[0].find(part), std::string::npos) << problems[0] << " lacks " << part;
  }
}

TEST(MonitorCheck, NothingIsWrongWithASetUpThatIsWell) {
  EXPECT_TRUE(Watch().Problems().empty()) << ::testing::PrintToString(Watch().Problems());
}

TEST(MonitorCheck, NamesWhoIsMissing) {
  ExpectedSetup expected = kExpected;
  expected.processes.push_back("sim-arm");
  ExpectOne(Watch().Problems(expected), {"process sim-arm", "never heard"});
  expected = kExpected;
  expected.cameras.push_back("LEFT");
  ExpectOne(Watch().Problems(expected), {"camera LEFT", "never heard"});
}

TEST(MonitorCheck, AnEmptyBusIsWrong) {
  ExpectOne(FindProblems(MonitorModel(), {}, {}, kStart), {"no process was heard"});
}

TEST(MonitorCheck, NamesWhoFellSilent) {
  Watch watch;
  watch.ppf_ends = 5;
  ExpectOne(watch.Problems(), {"process ppf", "silent for 6.0 s", "pid 100 on robot"});
  MonitorLimits limits;
  limits.max_silence = 7.0;
  EXPECT_TRUE(watch.Problems(kExpected, limits).empty());
  watch.ppf_ends = 10;
  watch.camera_ends = 5;
  ExpectOne(watch.Problems(), {"camera XTION", "silent for 6.0 s"});
}

TEST(MonitorCheck, WatchersMayComeAndGo) {
  Watch watch;
  watch.add = [](MonitorModel* model) {
    process_status_t progress = MadeProcess("progress");
    progress.config_hash = "other";
    progress.state = "lost";
    Send(model, "PROCESS_STATUS", progress, kStart);
  };
  EXPECT_TRUE(watch.Problems().empty()) << ::testing::PrintToString(watch.Problems());
}

TEST(MonitorCheck, TellsARestart) {
  Watch watch;
  watch.change_ppf = [](int second, process_status_t* ppf) {
    if (second < 6) return;
    ppf->pid = 200;
    ppf->start_utime = kStart + 6 * kSecond;
  };
  ExpectOne(watch.Problems(), {"process ppf", "started again", "200"});
}

TEST(MonitorCheck, TellsAStateThatIsWrongOrWas) {
  Watch watch;
  watch.change_ppf = [](int second, process_status_t* ppf) {
    if (second == 9) ppf->state = "no calibration";
  };
  ExpectOne(watch.Problems(), {"process ppf: no calibration"});
  watch.change_ppf = [](int second, process_status_t* ppf) {
    if (second == 4) ppf->state = "no calibration";
  };
  ExpectOne(watch.Problems(), {"process ppf", "ok again", "no calibration"});
  // What waits when it starts and is then well was never wrong.
  watch.change_ppf = [](int second, process_status_t* ppf) {
    if (second < 4) ppf->state = "waiting";
  };
  EXPECT_TRUE(watch.Problems().empty());
}

TEST(MonitorCheck, TellsLossesAndDecodeErrorsByChannel) {
  Watch watch;
  watch.change_ppf = [](int second, process_status_t* ppf) {
    ppf->channels[0].num_lost = 50 + (second > 3 ? 2 : 0);
    ppf->channels[0].num_overwritten = second;  // As it is meant for the newest image.
  };
  ExpectOne(watch.Problems(), {"process ppf", "2 messages of CAMERA_XTION were lost"});
  MonitorLimits limits;
  limits.max_lost = 2;
  EXPECT_TRUE(watch.Problems(kExpected, limits).empty());
  watch.change_ppf = [](int second, process_status_t* ppf) {
    ppf->channels[0].num_decode_errors = second > 3 ? 1 : 0;
  };
  ExpectOne(watch.Problems(), {"process ppf", "1 messages of CAMERA_XTION", "decoded"});
}

TEST(MonitorCheck, TellsASmallReceiveBufferWithItsCommand) {
  Watch watch;
  watch.change_ppf = [](int, process_status_t* ppf) { ppf->receive_buffer_granted = 212992; };
  ExpectOne(watch.Problems(), {"process ppf", "212992", "sysctl -w net.core.rmem_max=4194304"});
}

TEST(MonitorCheck, TellsAnotherConfiguration) {
  Watch watch;
  watch.change_ppf = [](int, process_status_t* ppf) { ppf->config_hash = "beef"; };
  ExpectOne(watch.Problems(), {"process ppf", "another configuration (beef)", "the one given"});
  ExpectedSetup none;
  watch.add = [](MonitorModel* model) {
    Send(model, "PROCESS_STATUS", MadeProcess("sim-arm"), kStart + 9 * kSecond);
  };
  ExpectOne(watch.Problems(none), {"process ppf", "the others"});
}

TEST(MonitorCheck, TellsLatenciesOverTheirLimit) {
  const Watch watch;
  MonitorLimits limits;
  limits.max_p99["match"] = 0.025;
  const std::vector<std::string> problems = watch.Problems(kExpected, limits);
  ASSERT_EQ(problems.size(), 2U);  // Of both processes.
  EXPECT_NE(problems[0].find("p99 of stage match is 30 ms"), std::string::npos) << problems[0];
  limits.max_p99["match"] = 0.035;
  EXPECT_TRUE(watch.Problems(kExpected, limits).empty());
  // What is no number is not within a limit.
  Watch bad;
  bad.change_ppf = [](int, process_status_t* ppf) { ppf->stages[0].latency_p99 = std::nan(""); };
  ExpectOne(bad.Problems(kExpected, limits), {"process ppf", "stage match"});
}

TEST(MonitorCheck, TellsACameraThatDoesNotStreamOrStopped) {
  Watch watch;
  watch.change_camera = [](int second, camera_status_v2_t* camera) {
    if (second < 8) return;
    camera->state = camera_status_v2_t::STALLED;
    camera->message = "gives no frame for 1.0 s";
  };
  ExpectOne(watch.Problems(), {"camera XTION: stalled: gives no frame"});
  watch.change_camera = [](int second, camera_status_v2_t* camera) {
    if (second == 5) camera->state = camera_status_v2_t::LOST;
  };
  ExpectOne(watch.Problems(), {"camera XTION", "streams again", "1 times"});
  watch.change_camera = [](int, camera_status_v2_t* camera) { camera->state = 99; };
  ExpectOne(watch.Problems(), {"camera XTION: in an unknown state"});
  // One that is searched for at first and then streams is well.
  watch.change_camera = [](int second, camera_status_v2_t* camera) {
    if (second < 3) camera->state = camera_status_v2_t::SEARCHING;
  };
  EXPECT_TRUE(watch.Problems().empty());
}

TEST(MonitorCheck, TellsMissedFramesAndLatency) {
  Watch watch;
  watch.change_camera = [](int second, camera_status_v2_t* camera) {
    camera->num_missed = 10 * second;
  };
  ExpectOne(watch.Problems(), {"camera XTION", "90 of 360 frames"});
  watch.change_camera = [](int, camera_status_v2_t* camera) { camera->latency = 1.5; };
  ExpectOne(watch.Problems(), {"camera XTION", "latency is 1.5 s"});
  watch.change_camera = [](int, camera_status_v2_t* camera) { camera->latency = std::nan(""); };
  ExpectOne(watch.Problems(), {"camera XTION", "latency"});
}

TEST(MonitorCheck, TellsACalibrationThatHoldsNoMore) {
  Watch watch;
  watch.add = [](MonitorModel* model) {
    handeye_check_t check{};
    check.utime = kStart;
    check.camera = "XTION";
    check.state = handeye_check_t::DRIFTED;
    check.reason = "the camera has moved by 4 mm";
    Send(model, "HANDEYE_CHECK", check, kStart + 9 * kSecond);
  };
  ExpectOne(watch.Problems(), {"hand-eye", "XTION", "drifted", "moved by 4 mm"});
}

TEST(MonitorCheck, TellsWhatIsWrongOnTheBusItself) {
  Watch watch;
  watch.add = [](MonitorModel* model) {
    model->Add("PROCESS_STATUS", kStart, std::vector<std::byte>(4));
  };
  ExpectOne(watch.Problems(), {"channel PROCESS_STATUS", "several types"});
  watch.add = [](MonitorModel* model) {
    std::vector<std::byte> cut = Encode(MadeCamera("XTION"));
    cut.pop_back();
    model->Add("CAMERA_XTION_STATUS", kStart, cut);
  };
  ExpectOne(watch.Problems(), {"channel CAMERA_XTION_STATUS", "1 messages are malformed"});
}

TEST(MonitorCheck, WhatComesFromOutsideIsFitToBeShown) {
  Watch watch;
  watch.add = [](MonitorModel* model) {
    process_status_t evil = MadeProcess("\033[2Jevil\n");
    evil.state = "\033]0;owned\007";
    evil.host =
        "\x9b"
        "31m";
    evil.channels[0].channel = "\033[5A";
    Send(model, "PROCESS_STATUS", evil, kStart);
    camera_status_v2_t camera = MadeCamera("\r\033[K");
    camera.state = camera_status_v2_t::LOST;
    camera.message = "\033c";
    Send(model, "CAMERA_\033_STATUS", camera, kStart);
    model->Add("\033[31m", kStart, std::vector<std::byte>(9));
    model->Add("\033[31m", kStart, std::vector<std::byte>(2));
  };
  const std::vector<std::string> problems = watch.Problems();
  EXPECT_GE(problems.size(), 4U);
  for (const std::string& problem : problems) {
    for (const char c : problem) EXPECT_TRUE(c >= 0x20 && c <= 0x7e) << problem;
  }
}

}  // namespace
}  // namespace vantage
