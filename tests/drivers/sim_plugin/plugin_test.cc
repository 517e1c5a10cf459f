// The simulated device through the ordinary OpenNI2 API, as any program sees it.
#include <OpenNI.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <string>

#include "command_module.h"
#include "common/depth_image.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sim_arm.h"
#include "tests/drivers/sim_plugin/loaded_plugin.h"

namespace vantage {
namespace {

constexpr int kLongMs = 20'000;  // Far more than anything takes; only a failure waits for it.
constexpr int kShortMs = 300;    // A silence of nine frames.
const std::string kUri = std::string("vantage-sim://") + kTestSerial;

void SetPose(double azimuth_deg, double elevation_deg, double radius) {
  Command("sim_test_set_pose", azimuth_deg * kDegree, elevation_deg * kDegree, radius);
}

bool WaitForFrame(openni::VideoStream* stream, int timeout_ms) {
  int ready = -1;
  return openni::OpenNI::waitForAnyStream(&stream, 1, &ready, timeout_ms) == openni::STATUS_OK;
}

class SimPlugin : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
    openni::Array<openni::DeviceInfo> devices;
    openni::OpenNI::enumerateDevices(&devices);
    ASSERT_EQ(devices.getSize(), 1);
    ASSERT_EQ(devices[0].getUri(), kUri);
    ASSERT_EQ(device_.open(kUri.c_str()), openni::STATUS_OK);
    ASSERT_EQ(depth_.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
  }
  void TearDown() override {
    depth_.destroy();
    device_.close();
    openni::OpenNI::shutdown();
  }
  /// Starts and takes one frame.
  openni::VideoFrameRef First(openni::VideoStream* stream) {
    openni::VideoFrameRef frame;
    EXPECT_EQ(stream->start(), openni::STATUS_OK);
    EXPECT_TRUE(WaitForFrame(stream, kLongMs));
    EXPECT_EQ(stream->readFrame(&frame), openni::STATUS_OK);
    return frame;
  }

  openni::Device device_;
  openni::VideoStream depth_;
};

std::vector<uint16_t> Expected(const CameraModel& camera, double azimuth_deg) {
  const SimScene scene = TestScene();
  SceneRenderer renderer(scene, camera);
  DepthImage image =
      renderer.Render(ViewOnSphere(kTestTarget, azimuth_deg * kDegree, 50.0 * kDegree, 0.7)).depth;
  for (float& z : image.depth) {
    if (z < 0.4F || z > 4.0F) z = DepthImage::kInvalid;
  }
  return DepthToMillimetres(image);
}

TEST_F(SimPlugin, TellsItsSerialAndExactIntrinsics) {
  std::array<char, 64> serial{};
  int size = static_cast<int>(serial.size());
  ASSERT_EQ(device_.getProperty(openni::DEVICE_PROPERTY_SERIAL_NUMBER, serial.data(), &size),
            openni::STATUS_OK);
  EXPECT_STREQ(serial.data(), kTestSerial);
  const CameraModel camera = CameraFromFieldOfView(
      640, 480, double{depth_.getHorizontalFieldOfView()}, double{depth_.getVerticalFieldOfView()});
  EXPECT_NEAR(camera.fx, 570.34, 1e-3);
  EXPECT_NEAR(camera.fy, 570.34, 1e-3);
  EXPECT_EQ(depth_.getVideoMode().getResolutionX(), 640);
  EXPECT_EQ(depth_.getVideoMode().getFps(), 30);
  EXPECT_NE(device_.getSensorInfo(openni::SENSOR_COLOR), nullptr);
  EXPECT_EQ(device_.getSensorInfo(openni::SENSOR_IR), nullptr);
}

TEST_F(SimPlugin, DeliversNothingBeforeAPoseThenTheScene) {
  ASSERT_EQ(depth_.start(), openni::STATUS_OK);
  EXPECT_FALSE(WaitForFrame(&depth_, kShortMs));
  SetPose(-70.0, 50.0, 0.7);
  openni::VideoFrameRef frame;
  ASSERT_TRUE(WaitForFrame(&depth_, kLongMs));
  ASSERT_EQ(depth_.readFrame(&frame), openni::STATUS_OK);
  const std::vector<uint16_t> expected = Expected(CameraModel{}, -70.0);
  ASSERT_EQ(frame.getDataSize(), static_cast<int>(2 * expected.size()));
  const auto* pixels = static_cast<const uint16_t*>(frame.getData());
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), pixels));
  EXPECT_GT(std::count_if(expected.begin(), expected.end(), [](uint16_t z) { return z > 0; }), 1e5);
}

TEST_F(SimPlugin, TimestampsFollowTheFrameIndex) {
  SetPose(-70.0, 50.0, 0.7);
  openni::VideoFrameRef frame = First(&depth_);
  for (int i = 0; i < 10; ++i) {
    const uint64_t last_time = frame.getTimestamp();
    const int last_index = frame.getFrameIndex();
    ASSERT_TRUE(WaitForFrame(&depth_, kLongMs));
    ASSERT_EQ(depth_.readFrame(&frame), openni::STATUS_OK);
    EXPECT_GT(frame.getFrameIndex(), last_index);
    EXPECT_GT(frame.getTimestamp(), last_time);
    // A frame is never taken before its place in the device's time.
    EXPECT_GE(static_cast<double>(frame.getTimestamp()), frame.getFrameIndex() * 33333.0);
  }
}

TEST_F(SimPlugin, HalfResolutionAndColor) {
  openni::VideoMode mode = depth_.getVideoMode();
  mode.setResolution(320, 240);
  ASSERT_EQ(depth_.setVideoMode(mode), openni::STATUS_OK);
  mode.setFps(17);
  EXPECT_NE(depth_.setVideoMode(mode), openni::STATUS_OK);
  SetPose(-70.0, 50.0, 0.7);
  const openni::VideoFrameRef frame = First(&depth_);
  const std::vector<uint16_t> expected = Expected(CameraModel{}.Scaled(0.5), -70.0);
  ASSERT_EQ(frame.getDataSize(), static_cast<int>(2 * expected.size()));
  EXPECT_TRUE(
      std::equal(expected.begin(), expected.end(), static_cast<const uint16_t*>(frame.getData())));

  openni::VideoStream color;
  ASSERT_EQ(color.create(device_, openni::SENSOR_COLOR), openni::STATUS_OK);
  const openni::VideoFrameRef image = First(&color);
  EXPECT_EQ(image.getWidth(), 640);
  ASSERT_EQ(image.getDataSize(), 640 * 480 * 3);
  const auto* rgb = static_cast<const uint8_t*>(image.getData());
  std::array<size_t, 256> histogram{};
  for (int i = 0; i < image.getDataSize(); ++i) ++histogram[rgb[i]];
  EXPECT_GT(std::count_if(histogram.begin(), histogram.end(), [](size_t n) { return n > 0; }), 10);
  color.destroy();
}

TEST_F(SimPlugin, CropsAndMirrors) {
  ASSERT_TRUE(depth_.isCroppingSupported());
  ASSERT_EQ(depth_.setCropping(200, 150, 240, 160), openni::STATUS_OK);
  EXPECT_NE(depth_.setCropping(600, 150, 240, 160), openni::STATUS_OK);
  ASSERT_EQ(depth_.setMirroringEnabled(true), openni::STATUS_OK);
  SetPose(-70.0, 50.0, 0.7);
  const openni::VideoFrameRef frame = First(&depth_);
  ASSERT_EQ(frame.getWidth(), 240);
  ASSERT_EQ(frame.getHeight(), 160);
  EXPECT_TRUE(frame.getCroppingEnabled());
  EXPECT_EQ(frame.getCropOriginX(), 200);
  const std::vector<uint16_t> expected = Expected(CameraModel{}, -70.0);
  const auto* pixels = static_cast<const uint16_t*>(frame.getData());
  for (size_t v = 0; v < 160; ++v) {
    for (size_t u = 0; u < 240; ++u) {
      ASSERT_EQ(pixels[v * 240 + u], expected[(v + 150) * 640 + (639 - 200 - u)]);
    }
  }
}

/// Counts what OpenNI2 tells of devices.
class Events : public openni::OpenNI::DeviceConnectedListener,
               public openni::OpenNI::DeviceDisconnectedListener {
 public:
  Events() {
    openni::OpenNI::addDeviceConnectedListener(this);
    openni::OpenNI::addDeviceDisconnectedListener(this);
  }
  ~Events() override {
    openni::OpenNI::removeDeviceConnectedListener(this);
    openni::OpenNI::removeDeviceDisconnectedListener(this);
  }
  void onDeviceConnected(const openni::DeviceInfo* info) override { Count(info, &connected_); }
  void onDeviceDisconnected(const openni::DeviceInfo* info) override {
    Count(info, &disconnected_);
  }
  bool WaitFor(int connected, int disconnected) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::milliseconds(kLongMs), [&] {
      return connected_ == connected && disconnected_ == disconnected;
    });
  }

 private:
  void Count(const openni::DeviceInfo* info, int* counter) {
    const std::lock_guard lock(mutex_);
    if (info->getUri() == kUri) ++*counter;
    changed_.notify_all();
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  int connected_ = 0;
  int disconnected_ = 0;
};

TEST_F(SimPlugin, UnpluggedItStopsAndReplugsUnderTheSameSerial) {
  Events events;
  SetPose(-70.0, 50.0, 0.7);
  First(&depth_);
  Fault(SimFault::Kind::kUnplug);
  ASSERT_TRUE(events.WaitFor(0, 1));
  openni::VideoFrameRef frame;
  while (WaitForFrame(&depth_, kShortMs)) depth_.readFrame(&frame);  // What was under way.
  EXPECT_FALSE(WaitForFrame(&depth_, kShortMs));
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  EXPECT_EQ(devices.getSize(), 0);
  frame.release();
  depth_.destroy();
  device_.close();
  EXPECT_NE(device_.open(kUri.c_str()), openni::STATUS_OK);

  Fault(SimFault::Kind::kReplug);
  ASSERT_TRUE(events.WaitFor(1, 1));
  ASSERT_EQ(device_.open(kUri.c_str()), openni::STATUS_OK);
  ASSERT_EQ(depth_.create(device_, openni::SENSOR_DEPTH), openni::STATUS_OK);
  EXPECT_EQ(First(&depth_).getWidth(), 640);
}

TEST_F(SimPlugin, UnpluggedForATimeItComesBackByItself) {
  Events events;
  Fault(SimFault::Kind::kUnplug, 0.2);
  EXPECT_TRUE(events.WaitFor(1, 1));
}

TEST_F(SimPlugin, StallsUntilReplug) {
  SetPose(-70.0, 50.0, 0.7);
  First(&depth_);
  Fault(SimFault::Kind::kStall);
  openni::VideoFrameRef frame;
  while (WaitForFrame(&depth_, kShortMs)) depth_.readFrame(&frame);
  EXPECT_FALSE(WaitForFrame(&depth_, kShortMs));
  Fault(SimFault::Kind::kReplug);
  EXPECT_TRUE(WaitForFrame(&depth_, kLongMs));
}

TEST_F(SimPlugin, ShortFrameComesOnce) {
  SetPose(-70.0, 50.0, 0.7);
  openni::VideoFrameRef frame = First(&depth_);
  EXPECT_EQ(frame.getDataSize(), 640 * 480 * 2);
  Fault(SimFault::Kind::kShortFrame);
  int short_frames = 0;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(WaitForFrame(&depth_, kLongMs));
    ASSERT_EQ(depth_.readFrame(&frame), openni::STATUS_OK);
    if (frame.getDataSize() == 640 * 480) ++short_frames;
  }
  EXPECT_EQ(short_frames, 1);
}

TEST_F(SimPlugin, StartsAndStopsManyTimes) {
  SetPose(-70.0, 50.0, 0.7);
  openni::VideoFrameRef frame;
  for (int i = 0; i < 15; ++i) {
    ASSERT_EQ(depth_.start(), openni::STATUS_OK);
    if (i % 3 == 0) {
      ASSERT_TRUE(WaitForFrame(&depth_, kLongMs));
      ASSERT_EQ(depth_.readFrame(&frame), openni::STATUS_OK);
    }
    depth_.stop();
  }
}

TEST_F(SimPlugin, RecordsAndPlaysBack) {
  std::string folder = (std::filesystem::temp_directory_path() / "vantage_sim_XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const std::string file = folder + "/recording.oni";
  SetPose(-70.0, 50.0, 0.7);
  openni::Recorder recorder;
  ASSERT_EQ(recorder.create(file.c_str()), openni::STATUS_OK);
  ASSERT_EQ(recorder.attach(depth_), openni::STATUS_OK);
  ASSERT_EQ(depth_.start(), openni::STATUS_OK);
  ASSERT_EQ(recorder.start(), openni::STATUS_OK);
  openni::VideoFrameRef frame;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(WaitForFrame(&depth_, kLongMs));
    ASSERT_EQ(depth_.readFrame(&frame), openni::STATUS_OK);
  }
  recorder.stop();
  recorder.destroy();
  frame.release();
  depth_.stop();

  openni::Device playback;
  ASSERT_EQ(playback.open(file.c_str()), openni::STATUS_OK);
  openni::VideoStream stream;
  ASSERT_EQ(stream.create(playback, openni::SENSOR_DEPTH), openni::STATUS_OK);
  const std::vector<uint16_t> expected = Expected(CameraModel{}, -70.0);
  const openni::VideoFrameRef recorded = First(&stream);
  ASSERT_EQ(recorded.getDataSize(), static_cast<int>(2 * expected.size()));
  EXPECT_TRUE(std::equal(
      expected.begin(), expected.end(), static_cast<const uint16_t*>(recorded.getData())));
  stream.destroy();
  playback.close();
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace vantage
