// Recordings: made by this driver and by OpenNI2's own recorder, played in lock-step.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "common/rng.h"
#include "tests/drivers/openni2_plugin/openni2_fixture.h"

namespace vantage {
namespace {

class Openni2Recording : public Openni2Plugin {
 protected:
  /// Records through OpenNI2's own recorder, not ours.
  void Record(int num_frames, bool mirrored = false) {
    ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
    SetPose();
    SetAbilities({});
    {
      openni::Device device;
      openni::VideoStream depth;
      openni::VideoStream color;
      openni::Recorder recorder;
      ASSERT_EQ(device.open(openni::ANY_DEVICE), openni::STATUS_OK);
      ASSERT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
      ASSERT_EQ(color.create(device, openni::SENSOR_COLOR), openni::STATUS_OK);
      depth.setMirroringEnabled(mirrored);
      color.setMirroringEnabled(mirrored);
      ASSERT_EQ(recorder.create(file().c_str()), openni::STATUS_OK);
      ASSERT_EQ(recorder.attach(depth), openni::STATUS_OK);
      ASSERT_EQ(recorder.attach(color), openni::STATUS_OK);
      ASSERT_EQ(recorder.start(), openni::STATUS_OK);
      ASSERT_EQ(depth.start(), openni::STATUS_OK);
      ASSERT_EQ(color.start(), openni::STATUS_OK);
      for (int i = 0; i < num_frames; ++i) {
        openni::VideoStream* stream = &depth;
        int ready = -1;
        ASSERT_EQ(openni::OpenNI::waitForAnyStream(&stream, 1, &ready, 20'000), openni::STATUS_OK);
        openni::VideoFrameRef frame;
        ASSERT_EQ(depth.readFrame(&frame), openni::STATUS_OK);
      }
      recorder.stop();
      recorder.destroy();
      depth.stop();
      color.stop();
    }
    openni::OpenNI::shutdown();
  }
  /// Takes images while the camera moves now and then, so that no two stretches look alike.
  [[nodiscard]] bool GrabMoving(int num_poses, size_t frames_each) {
    Rng rng(3);
    for (int i = 0; i < num_poses; ++i) {
      SetPose(kTestAzimuth + rng.Uniform(-0.5, 0.5));
      if (!GrabFrames(frames_each)) return false;
    }
    return true;
  }
  /// Plays a file; what came live stays in `live_`.
  void Play(const std::string& recording) {
    if (live_.empty()) live_ = std::exchange(frames_, {});
    frames_.clear();
    camera_.reset();
    Create("oni:" + recording);
    ASSERT_TRUE(GrabAll()) << camera_->status().message;
  }
  /// Every live frame after the recording's first is in it, at its place in time and as it was;
  /// with color the same pairs.
  void ExpectPlaybackIsLive() const;

  std::vector<CameraFrame> live_;
};

void Openni2Recording::ExpectPlaybackIsLive() const {
  ASSERT_FALSE(frames_.empty());
  ASSERT_FALSE(live_.empty());
  // Recordings count time from their first frame. Which of the live ones that was shows in the last
  // ones' distances to it.
  std::map<int64_t, const CameraFrame*> recorded;
  for (const CameraFrame& frame : frames_) recorded[frame.device_time_us] = &frame;
  size_t most = 0;
  std::vector<std::pair<const CameraFrame*, const CameraFrame*>> matches;
  for (size_t k = 0; k < std::min<size_t>(live_.size(), 6); ++k) {
    for (const CameraFrame& begin : frames_) {
      const int64_t offset = live_[k].device_time_us - begin.device_time_us;
      std::vector<std::pair<const CameraFrame*, const CameraFrame*>> found;
      for (const CameraFrame& frame : live_) {
        const auto same = recorded.find(frame.device_time_us - offset);
        if (same != recorded.end()) found.emplace_back(&frame, same->second);
      }
      if (found.size() > most) matches = found;
      most = std::max(most, found.size());
    }
  }
  // Color's recording begins after the first pair.
  ASSERT_GE(matches.size() + 5, live_.size());
  for (const auto& [live, played] : matches) {
    ASSERT_EQ(played->depth_mm, live->depth_mm);
    if (!live->color || !played->color) continue;
    ASSERT_EQ(played->color->data, live->color->data);
  }
}

TEST_F(Openni2Recording, DepthIsPlayedBackByteForByte) {
  Create("index:0", {.file = file()});
  ASSERT_TRUE(GrabMoving(6, 4));
  EXPECT_EQ(camera_->status().message, "");
  Play(file());
  ExpectPlaybackIsLive();
  EXPECT_EQ(camera_->status().num_bad, 0);
  EXPECT_EQ(camera_->status().num_missed, 0);
}

TEST_F(Openni2Recording, ColorIsPlayedBackWithItsDepth) {
  options_.stream.color = true;
  Create("index:0", {.file = file()});
  ASSERT_TRUE(GrabMoving(6, 4));
  Play(file());
  ExpectPlaybackIsLive();
  const auto num_pairs =
      std::ranges::count_if(frames_, [](const auto& frame) { return frame.color.has_value(); });
  EXPECT_GE(static_cast<size_t>(num_pairs) + 1, frames_.size());
}

// OpenNI2 stamps the first image of each stream 0. A recording that began between a depth image and
// its color would pair each with another one's.
TEST_F(Openni2Recording, PairsStayPairsThoughColorComesLater) {
  abilities_.color_delay = std::chrono::milliseconds(12);
  options_.stream.color = true;
  Create("index:0", {.file = file()});
  constexpr int kNumPoses = 12;
  const auto azimuth = [](int i) { return kTestAzimuth + 0.05 * i; };
  for (int i = 0; i < kNumPoses; ++i) {
    SetPose(azimuth(i));
    ASSERT_TRUE(GrabFrames(2));
  }
  Play(file());
  // Images of one exposure show the same pose.
  std::map<std::vector<uint16_t>, std::vector<uint8_t>> color_of_depth;
  for (int i = 0; i < kNumPoses; ++i) {
    ExpectedImages expected(azimuth(i));
    color_of_depth[expected.Depth()] = expected.Color();
  }
  int num_pairs = 0;
  for (const CameraFrame& frame : frames_) {
    if (!frame.color) continue;
    ASSERT_TRUE(color_of_depth.contains(frame.depth_mm));
    EXPECT_EQ(frame.color->data, color_of_depth[frame.depth_mm]);
    ++num_pairs;
  }
  EXPECT_GE(num_pairs, kNumPoses);
}

TEST_F(Openni2Recording, WithoutAnyColorDepthIsRecordedAlone) {
  options_.stream.color = true;
  Create("index:0", {.file = file()});
  Fault(SimFault::Kind::kColorStop);
  ASSERT_TRUE(GrabFrames(75));
  Play(file());
  EXPECT_GE(frames_.size(), 5U);
}

TEST_F(Openni2Recording, AFileIntoWhichNothingCameIsRemoved) {
  options_.stream.color = true;
  Create("index:0", {.file = file()});
  Fault(SimFault::Kind::kStall);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kStreaming; }));
  camera_.reset();
  EXPECT_FALSE(std::filesystem::exists(file()) && frames_.empty());
}

TEST_F(Openni2Recording, EveryOpeningHasAFileOfItsOwn) {
  std::ofstream(folder_ / "recording-3.oni") << "another's";
  Create("index:0", {.file = file()});
  ASSERT_TRUE(GrabFrames(3));
  for (const int reconnect : {1, 2}) {
    Fault(SimFault::Kind::kUnplug);
    ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kSearching; }));
    Fault(SimFault::Kind::kReplug);
    ASSERT_TRUE(GrabUntil([&] { return camera_->status().num_reconnects == reconnect; }));
    ASSERT_TRUE(GrabFrames(3));
  }
  for (const char* name : {"recording.oni", "recording-2.oni", "recording-4.oni"}) {
    Play(folder_ / name);
    EXPECT_GE(frames_.size(), 3U) << name;
    EXPECT_EQ(frames_.front().depth_mm, ExpectedImages().Depth());
  }
  EXPECT_EQ(std::filesystem::file_size(folder_ / "recording-3.oni"), 9U);
}

TEST_F(Openni2Recording, AFileThatCannotBeOneIsRefused) {
  std::ofstream(file()) << "precious";
  for (const auto& [path, reason] :
       {std::pair(file(), "exists and is not overwritten"),
        std::pair(std::string(folder_ / "absent/recording.oni"), "lies in a folder"),
        std::pair(std::string(folder_ / "recording.avi"), "has no ending .oni")}) {
    const auto api = Openni2Api::Create({.file = path});
    ASSERT_FALSE(api.ok());
    EXPECT_NE(api.error().message.find(reason), std::string::npos) << api.error().message;
  }
  EXPECT_EQ(std::filesystem::file_size(file()), 8U);
}

TEST_F(Openni2Recording, AFullDiskIsToldAndStreamingGoesOn) {
  Create("index:0", {.file = file(), .min_free_bytes = INT64_MAX});
  ASSERT_TRUE(GrabFrames(5));
  EXPECT_NE(camera_->status().message.find("MB are free on its disk"), std::string::npos)
      << camera_->status().message;
  EXPECT_EQ(camera_->status().state, CameraState::kStreaming);
}

TEST_F(Openni2Recording, HostileFramesWhileRecordingDoNoHarm) {
  options_.stream.color = true;
  Create("index:0", {.file = file()});
  ASSERT_TRUE(GrabFrames(5));
  for (const SimFault::Kind kind :
       {SimFault::Kind::kShortFrame, SimFault::Kind::kResized, SimFault::Kind::kStampBack}) {
    Fault(kind);
    ASSERT_TRUE(GrabFrames(4));
  }
  Play(file());
  EXPECT_GE(frames_.size(), 8U);
}

TEST_F(Openni2Recording, PlaysEveryFrameOnceAndEnds) {
  Record(15);
  Create("oni:" + file());
  ASSERT_TRUE(GrabAll());
  // The recorder takes what the device delivers, at least what was read here.
  ASSERT_GE(frames_.size(), 14U);
  const std::vector<uint16_t> expected = ExpectedImages().Depth();
  for (size_t i = 0; i < frames_.size(); ++i) {
    EXPECT_EQ(frames_[i].depth_mm, expected) << i;
    EXPECT_NEAR(frames_[i].model->fx, 570.34, 1e-3);
    if (i == 0) continue;
    EXPECT_EQ(frames_[i].utime - frames_[i - 1].utime,
              frames_[i].device_time_us - frames_[i - 1].device_time_us);
    EXPECT_GT(frames_[i].device_time_us, frames_[i - 1].device_time_us);
  }
  EXPECT_EQ(camera_->status().num_captured, static_cast<int64_t>(frames_.size()));
  EXPECT_EQ(camera_->status().num_bad, 0);
  EXPECT_EQ(camera_->status().num_missed, 0);
}

TEST_F(Openni2Recording, MadeMirroredItIsTurned) {
  Record(5, true);
  options_.stream.color = true;
  Create("oni:" + file());
  ASSERT_TRUE(GrabAll());
  ExpectedImages expected;
  ASSERT_GE(frames_.size(), 4U);
  for (const CameraFrame& frame : frames_) {
    EXPECT_EQ(frame.depth_mm, expected.Depth());
    ASSERT_TRUE(frame.color.has_value());
    EXPECT_EQ(frame.color->data, expected.Color());
  }
}

// Cut anywhere, a recording is an error or plays what is whole.
TEST_F(Openni2Recording, ADamagedFileIsAnErrorOrAShorterOne) {
  Record(6);
  const auto size = static_cast<double>(std::filesystem::file_size(file()));
  for (const double share : {0.7, 0.3, 40.0 / size}) {
    std::filesystem::resize_file(file(), static_cast<uintmax_t>(share * size));
    frames_.clear();
    options_.device = *DeviceSelector::Parse("oni:" + file());
    options_.stall_timeout = std::chrono::milliseconds(200);
    Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
    ASSERT_TRUE(api.ok());
    Result<std::unique_ptr<Camera>> camera = Camera::Create(options_, std::move(api).value());
    if (!camera) {
      EXPECT_NE(camera.error().message.find(file()), std::string::npos) << camera.error().message;
      continue;
    }
    camera_ = std::move(camera).value();
    ASSERT_TRUE(GrabAll()) << share;
    for (const CameraFrame& frame : frames_) EXPECT_EQ(frame.depth_mm.size(), 640U * 480U);
    camera_.reset();
  }
}

}  // namespace
}  // namespace vantage
