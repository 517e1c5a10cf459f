#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "drivers/camera/camera.h"
#include "drivers/v4l2/v4l2_device.h"

namespace vantage {

/// A line of a description: the size that tests ask for, at 30 Hz. Frames come ten times as fast.
std::string SmallFormat(const std::string& fourcc);
/// A description of /dev/video0 with the serial CAM0 and more lines.
std::string DeviceZero(const std::string& lines);

/// A camera on emulated devices, grabbed from until something is so.
class LiveCamera {
 public:
  struct Settings {
    std::string device = "serial:CAM0";
    V4l2Options v4l2;
    StreamRequest stream = {.width = kWidth, .height = kHeight};
  };
  static constexpr int kWidth = 64;   // px
  static constexpr int kHeight = 48;  // px

  explicit LiveCamera(const Settings& settings);
  LiveCamera() : LiveCamera(Settings{}) {}

  /// Grabs until the condition holds. @return false: it does not within 30 s.
  [[nodiscard]] bool GrabUntil(const std::function<bool()>& condition);
  /// Grabs so many good frames more.
  [[nodiscard]] bool GrabFrames(size_t count);
  /// Grabs until a status was seen whose message contains the text.
  [[nodiscard]] bool GrabUntilMessage(const std::string& text);
  [[nodiscard]] bool GrabUntilState(CameraState state);

  [[nodiscard]] Camera& camera() { return *camera_; }
  [[nodiscard]] const CameraStatus& status() const { return camera_->status(); }
  [[nodiscard]] size_t num_frames() const { return num_frames_; }
  /// The last good one.
  [[nodiscard]] const CameraFrame& frame() const { return frame_; }
  /// Called with every good frame.
  std::function<void(const CameraFrame&)> on_frame;
  /// Every change so far.
  [[nodiscard]] const std::vector<CameraState>& states() const { return states_; }
  [[nodiscard]] bool HasBeen(CameraState state) const;
  /// State, counters and messages, to be shown when a test fails.
  [[nodiscard]] std::string Summary() const;

 private:
  void Grab();

  std::vector<CameraState> states_;
  std::set<std::string> messages_;
  std::unique_ptr<Camera> camera_;
  CameraFrame frame_;
  size_t num_frames_ = 0;
};

}  // namespace vantage
