// Any time of a log shows the same as playing it from its start to there.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/message_check.h"
#include "common/rng.h"
#include "tests/tools/run_fixtures.h"
#include "tools/viewer/log_player.h"
#include "tools/viewer/viewer_keys.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

class ViewerLog : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  // Poses at 100 Hz and an OBJECTS every 0.1 s.
  // @param jitter us by which every 7th event is stamped earlier than it comes
  [[nodiscard]] fs::path WriteLog(int num_events, int64_t jitter) const {
    const fs::path file = folder_ / "run.lcm";
    auto writer = EventLogWriter::Create(file);
    EXPECT_TRUE(writer.ok());
    for (int i = 0; i < num_events; ++i) {
      const int64_t utime = kRunStart + 10'000 * i - (i % 7 == 3 ? jitter : 0);
      if (i % 10 == 5) {
        const object_estimate_v3_t object = EstimateAt(1, "mug", Pose::Identity());
        EXPECT_TRUE((*writer)
                        ->Write(utime, "OBJECTS", Encode(ObjectsOf({object}, i / 10 + 1, utime)))
                        .ok());
      } else {
        Pose pose = Pose::Identity();
        pose.translation().x() = 0.01 * i;
        EXPECT_TRUE(
            (*writer)->Write(utime, "CAMERA_A_TO_WORLD", Encode(PoseToMessage(pose, utime))).ok());
      }
    }
    EXPECT_TRUE((*writer)->Close().ok());
    return file;
  }

  fs::path folder_ = fs::temp_directory_path() / ("viewer_log_" + std::to_string(getpid()));
};

// What differs when an event more or less was played.
void ExpectSame(const ViewerState& a, const ViewerState& b) {
  EXPECT_EQ(a.num_used(), b.num_used());
  EXPECT_EQ(a.num_lost(), b.num_lost());
  EXPECT_EQ(a.utime(), b.utime());
  EXPECT_EQ(a.steps().size(), b.steps().size());
  EXPECT_EQ(a.objects().num_viewpoints, b.objects().num_viewpoints);
  ASSERT_EQ(a.cameras().size(), b.cameras().size());
  for (const auto& [name, camera] : a.cameras()) {
    const ShownCamera& other = b.cameras().at(name);
    EXPECT_EQ(camera.path, other.path);
    ASSERT_EQ(camera.T_world_camera.has_value(), other.T_world_camera.has_value());
    if (camera.T_world_camera) {
      EXPECT_EQ(camera.T_world_camera->matrix(), other.T_world_camera->matrix());
    }
  }
}

TEST_F(ViewerLog, AnyTimeEqualsPlayingFromTheStart) {
  for (const int64_t jitter : {int64_t{0}, int64_t{35'000}}) {
    const fs::path log = WriteLog(30'000, jitter);  // More than there are keyframes for at first.
    auto player = LogPlayer::Open(log, {});
    ASSERT_TRUE(player.ok());
    ASSERT_TRUE((*player)->Survey([](double) {}).ok());
    EXPECT_EQ((*player)->state().num_used(), 30'000);
    Rng rng(4);
    for (int i = 0; i < 12; ++i) {
      const int64_t utime = kRunStart - 50'000 + rng.Below(300'200'000);
      (*player)->GoTo(utime);
      auto plain = LogPlayer::Open(log, {});
      (*plain)->GoTo(utime);
      ExpectSame((*player)->state(), (*plain)->state());
    }
    (*player)->GoTo((*player)->end_utime());
    EXPECT_EQ((*player)->state().num_used(), 30'000);
    (*player)->GoTo(kRunStart - 1'000'000);
    EXPECT_EQ((*player)->state().num_used(), 0);
  }
}

TEST_F(ViewerLog, KeysGoByEventAndView) {
  const fs::path log = WriteLog(100, 0);
  auto player = LogPlayer::Open(log, {});
  ASSERT_TRUE(player.ok());
  ASSERT_TRUE((*player)->Survey([](double) {}).ok());
  EXPECT_EQ((*player)->views().size(), 10U);
  const int64_t first = kRunStart + 50'000;
  EXPECT_EQ(KeyTime("Right", **player, kRunStart), first);
  EXPECT_EQ(KeyTime("Next", **player, first), first + 100'000);
  EXPECT_EQ(KeyTime("Prior", **player, first + 50'000), first);
  EXPECT_EQ(KeyTime("Left", **player, first), std::nullopt);
  EXPECT_EQ(KeyTime("Next", **player, (*player)->end_utime()), std::nullopt);
  EXPECT_EQ(KeyTime("Home", **player, first), kRunStart);
  EXPECT_EQ(KeyTime("End", **player, first), kRunStart + 990'000);
  EXPECT_EQ(KeyTime("x", **player, first), std::nullopt);
}

TEST_F(ViewerLog, OptionKeysGoAroundAndComeBack) {
  ViewerState state;
  const auto message =
      ObjectsOf({EstimateAt(3, "mug", Pose::Identity()), EstimateAt(8, "mug", Pose::Identity())},
                1,
                kRunStart);
  state.Apply("OBJECTS", kRunStart, Encode(message));
  ViewerOptions options;
  EXPECT_TRUE(ChangeOptions("o", state, &options));
  EXPECT_EQ(options.object, 8);
  EXPECT_TRUE(ChangeOptions("o", state, &options));
  EXPECT_EQ(options.object, 3);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ChangeOptions("v", state, &options));
  EXPECT_TRUE(options.vector.isApprox(ViewerOptions{}.vector));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(ChangeOptions("c", state, &options));
  EXPECT_EQ(options.cloud_color, ViewerOptions{}.cloud_color);
  EXPECT_FALSE(ChangeOptions("Left", state, &options));
  EXPECT_TRUE(ChangeOptions("o", ViewerState(), &options));
}

TEST_F(ViewerLog, ALogThatIsCutOffShowsWhatIsThere) {
  const fs::path log = WriteLog(1000, 0);
  fs::resize_file(log, fs::file_size(log) / 2 + 11);
  auto player = LogPlayer::Open(log, {});
  ASSERT_TRUE(player.ok());
  ASSERT_TRUE((*player)->Survey([](double) {}).ok());
  EXPECT_GT((*player)->state().num_used(), 400);
  EXPECT_LT((*player)->state().num_used(), 600);
  EXPECT_FALSE((*player)->Damage().empty());
}

}  // namespace
}  // namespace vantage
