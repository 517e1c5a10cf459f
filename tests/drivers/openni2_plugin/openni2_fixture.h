#pragma once

#include <OpenNI.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/camera/camera.h"
#include "drivers/openni2/openni2_api.h"
#include "drivers/sim/openni2_abilities.h"
#include "drivers/sim/sim_arm.h"
#include "drivers/sim/sim_camera.h"
#include "tests/drivers/sim_plugin/command_module.h"
#include "tests/drivers/sim_plugin/loaded_plugin.h"

namespace vantage {

constexpr double kTestAzimuth = -70.0 * kDegree;
constexpr double kTestElevation = 50.0 * kDegree;
constexpr double kTestRadius = 0.7;

inline void SetPose(double azimuth = kTestAzimuth) {
  Command("sim_test_set_pose", azimuth, kTestElevation, kTestRadius);
}

inline void SetAbilities(const SimAbilities& abilities) {
  Command("sim_test_abilities", &abilities);
}

/// What the simulated device shows from the test's pose.
class ExpectedImages {
 public:
  explicit ExpectedImages(double azimuth = kTestAzimuth) {
    setup_.scene = TestScene();
    setup_.sensor.SwitchAllOff();
    camera_.Expose(ViewOnSphere(kTestTarget, azimuth, kTestElevation, kTestRadius), 1, 0.0);
  }
  const std::vector<uint16_t>& Depth(int width = 640) { return camera_.Depth(width); }
  const std::vector<uint8_t>& Color(int width = 640) { return camera_.Color(width); }

 private:
  SimDeviceSetup setup_;
  SimCamera camera_{setup_};
};

class Openni2Plugin : public ::testing::Test {
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
  void Create(const std::string& device, const RecordTarget& record = {}) {
    options_.device = *DeviceSelector::Parse(device);
    options_.search_interval = std::chrono::milliseconds(50);
    options_.retry_interval = std::chrono::milliseconds(50);
    options_.on_change = [this](const CameraStatus& status) { states_.push_back(status.state); };
    Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create(record);
    ASSERT_TRUE(api.ok()) << api.error().message;
    SetPose();
    SetAbilities(abilities_);
    Result<std::unique_ptr<Camera>> camera = Camera::Create(options_, std::move(api).value());
    ASSERT_TRUE(camera.ok()) << camera.error().message;
    camera_ = std::move(camera).value();
  }
  /// Grabs until `done`; the bound is for failures only.
  [[nodiscard]] bool GrabUntil(const std::function<bool()>& done) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (std::chrono::steady_clock::now() < deadline) {
      if (std::optional<CameraFrame> frame = camera_->Grab(std::chrono::milliseconds(100))) {
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
  /// Grabs a recording to its end.
  [[nodiscard]] bool GrabAll() {
    return GrabUntil([this] { return camera_->status().state == CameraState::kLost; });
  }
  [[nodiscard]] std::string file() const { return folder_ / "recording.oni"; }

  std::filesystem::path folder_;
  SimAbilities abilities_;
  Camera::Options options_;
  std::unique_ptr<Camera> camera_;
  std::vector<CameraFrame> frames_;
  std::vector<CameraState> states_;
};

}  // namespace vantage
