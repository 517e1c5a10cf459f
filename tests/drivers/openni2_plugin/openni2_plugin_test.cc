// The camera class through the ordinary OpenNI2 API, on the simulated device and on a recording of
// it.
#include <OpenNI.h>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>

#include "common/depth_image.h"
#include "drivers/camera/camera.h"
#include "drivers/openni2/openni2_api.h"
#include "drivers/sim/fault_state.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sim_arm.h"
#include "tests/drivers/sim_plugin/command_module.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;

// Calls a sim_test_ function of the plugin that OpenNI2 has loaded.
template <class... Arguments>
void Command(const char* name, Arguments... arguments) {
  Dl_info library{};
  ASSERT_NE(dladdr(reinterpret_cast<void*>(oniInitialize), &library), 0);
  const std::filesystem::path plugin = std::filesystem::path(library.dli_fname).parent_path() /
                                       "OpenNI2/Drivers/libVantageSimTest.so.0";
  void* handle = dlopen(plugin.c_str(), RTLD_NOW | RTLD_NOLOAD);
  ASSERT_NE(handle, nullptr) << "OpenNI2 has not loaded " << plugin;
  auto* function = reinterpret_cast<void (*)(Arguments...)>(dlsym(handle, name));
  ASSERT_NE(function, nullptr);
  function(arguments...);
  dlclose(handle);
}

void Fault(SimFault::Kind kind, double duration = 0.0) {
  Command("sim_test_fault", static_cast<int>(kind), duration);
}

// What the simulated device shows from the test's pose, mm.
std::vector<uint16_t> Expected() {
  const SimScene scene = TestScene();
  SceneRenderer renderer(scene, CameraModel{});
  DepthImage image =
      renderer.Render(ViewOnSphere(kTestTarget, -70.0 * kDegree, 50.0 * kDegree, 0.7)).depth;
  for (float& z : image.depth) {
    if (z < 0.4F || z > 4.0F) z = DepthImage::kInvalid;
  }
  return DepthToMillimetres(image);
}

class Openni2Plugin : public ::testing::Test {
 protected:
  void Create(const std::string& device) {
    options_.device = *DeviceSelector::Parse(device);
    options_.search_interval = milliseconds(50);
    options_.retry_interval = milliseconds(50);
    options_.on_change = [this](const CameraStatus& status) { states_.push_back(status.state); };
    Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
    ASSERT_TRUE(api.ok()) << api.error().message;
    Command("sim_test_set_pose", -70.0 * kDegree, 50.0 * kDegree, 0.7);
    Result<std::unique_ptr<Camera>> camera = Camera::Create(options_, std::move(api).value());
    ASSERT_TRUE(camera.ok()) << camera.error().message;
    camera_ = std::move(camera).value();
  }
  // Grabs until `done`; the bound is for failures only.
  [[nodiscard]] bool GrabUntil(const std::function<bool()>& done) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < deadline) {
      if (std::optional<CameraFrame> frame = camera_->Grab(milliseconds(100))) {
        frames_.push_back(*std::move(frame));
      }
      if (done()) return true;
    }
    return false;
  }
  [[nodiscard]] bool GrabFrames(size_t count) {
    const size_t enough = frames_.size() + count;
    return GrabUntil([this, enough] { return frames_.size() >= enough; });
  }

  Camera::Options options_;
  std::unique_ptr<Camera> camera_;
  std::vector<CameraFrame> frames_;
  std::vector<CameraState> states_;
};

TEST_F(Openni2Plugin, StreamsByIndexUriAndSerial) {
  const std::string serial = kTestSerial;
  for (const std::string& device :
       {std::string("index:0"), "uri:vantage-sim://" + serial, "serial:" + serial}) {
    Create(device);
    frames_.clear();
    ASSERT_TRUE(GrabFrames(3)) << device << ": " << camera_->status().message;
    const CameraFrame& frame = frames_.back();
    EXPECT_EQ(frame.serial, serial);
    EXPECT_EQ(frame.depth_mm, Expected());
    EXPECT_NEAR(frame.model->fx, 570.34, 1e-3);
    EXPECT_NEAR(frame.model->fy, 570.34, 1e-3);
    EXPECT_EQ(frame.model->cx, 319.5);
    EXPECT_GT(frame.device_time_us, frames_[frames_.size() - 2].device_time_us);
    EXPECT_GT(frame.utime, frames_[frames_.size() - 2].utime);
    camera_.reset();
  }
}

TEST_F(Openni2Plugin, AnAbsentSerialIsWaitedFor) {
  Create("serial:other");
  ASSERT_TRUE(GrabUntil([this] { return !camera_->status().message.empty(); }));
  EXPECT_EQ(camera_->status().state, CameraState::kSearching);
  EXPECT_NE(camera_->status().message.find("(serial " + std::string(kTestSerial) + ")"),
            std::string::npos)
      << camera_->status().message;
}

TEST_F(Openni2Plugin, ComesBackAfterUnplugging) {
  Create("index:0");
  ASSERT_TRUE(GrabFrames(3));
  Fault(SimFault::Kind::kUnplug);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kSearching; }));
  EXPECT_NE(std::ranges::find(states_, CameraState::kLost), states_.end());
  Fault(SimFault::Kind::kReplug);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_reconnects == 1; }));
  EXPECT_TRUE(GrabFrames(3));
  EXPECT_EQ(frames_.back().serial, kTestSerial);
}

TEST_F(Openni2Plugin, NoticesAStallAndReopens) {
  options_.stall_timeout = milliseconds(150);
  Create("index:0");
  ASSERT_TRUE(GrabFrames(3));
  Fault(SimFault::Kind::kStall);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kStalled; }));
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_reconnects == 1; }));
  Fault(SimFault::Kind::kReplug);
  EXPECT_TRUE(GrabFrames(3));
}

TEST_F(Openni2Plugin, CountsAndDropsAShortFrame) {
  Create("index:0");
  ASSERT_TRUE(GrabFrames(3));
  Fault(SimFault::Kind::kShortFrame);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_bad == 1; }));
  ASSERT_TRUE(GrabFrames(3));
  for (const CameraFrame& frame : frames_) EXPECT_EQ(frame.depth_mm.size(), 640U * 480U);
}

TEST_F(Openni2Plugin, GivesColorOfTheSameTime) {
  options_.stream.color = true;
  options_.stream.registration = Registration::kDepthToColor;
  Create("index:0");
  ASSERT_TRUE(GrabUntil([this] { return !frames_.empty() && frames_.back().color; }))
      << camera_->status().message;
  EXPECT_EQ(frames_.back().color->data.size(), 640U * 480U * 3U);
  EXPECT_TRUE(frames_.back().registered);
}

TEST_F(Openni2Plugin, AModeThatItLacksIsToldWithThoseItHas) {
  options_.stream.fps = 17;
  Create("index:0");
  ASSERT_TRUE(GrabUntil([this] {
    return camera_->status().message.find("expected one of: 640x480 at 30 Hz in 1 mm") !=
           std::string::npos;
  })) << camera_->status().message;
}

class Openni2Recording : public Openni2Plugin {
 protected:
  void SetUp() override {
    std::string folder = (std::filesystem::temp_directory_path() / "vantage_oni_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
  }
  void TearDown() override {
    camera_.reset();
    std::filesystem::remove_all(folder_);
  }
  // Records through OpenNI2's own recorder, not ours.
  void Record(int num_frames) {
    ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
    Command("sim_test_set_pose", -70.0 * kDegree, 50.0 * kDegree, 0.7);
    {
      openni::Device device;
      openni::VideoStream depth;
      openni::Recorder recorder;
      ASSERT_EQ(device.open(openni::ANY_DEVICE), openni::STATUS_OK);
      ASSERT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
      ASSERT_EQ(recorder.create(file().c_str()), openni::STATUS_OK);
      ASSERT_EQ(recorder.attach(depth), openni::STATUS_OK);
      ASSERT_EQ(depth.start(), openni::STATUS_OK);
      ASSERT_EQ(recorder.start(), openni::STATUS_OK);
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
    }
    openni::OpenNI::shutdown();
  }
  [[nodiscard]] std::string file() const { return folder_ / "recording.oni"; }

  std::filesystem::path folder_;
};

TEST_F(Openni2Recording, PlaysEveryFrameOnceAndEnds) {
  Record(15);
  Create("oni:" + file());
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kLost; }));
  // The recorder takes what the device delivers, at least what was read here.
  ASSERT_GE(frames_.size(), 14U);
  const std::vector<uint16_t> expected = Expected();
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

TEST_F(Openni2Recording, ADamagedFileIsAnError) {
  Record(3);
  std::filesystem::resize_file(file(), 40);
  options_.device = *DeviceSelector::Parse("oni:" + file());
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
  ASSERT_TRUE(api.ok());
  const auto camera = Camera::Create(options_, std::move(api).value());
  ASSERT_FALSE(camera.ok());
  EXPECT_NE(camera.error().message.find(file()), std::string::npos) << camera.error().message;
}

}  // namespace
}  // namespace vantage
