#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/result.h"
#include "drivers/clock/clock_filter.h"
#include "drivers/openni2/depth_device.h"
#include "drivers/openni2/device_selector.h"
#include "drivers/openni2/undistortion.h"

namespace vantage {

/// In the order of camera_status_t.
enum class CameraState { kSearching, kOpening, kStreaming, kStalled, kLost };

/// What a camera is doing.
struct CameraStatus {
  CameraState state = CameraState::kSearching;
  std::string message;  ///< why, in one sentence; empty when all is well
  std::string serial;   ///< of the device in use or last in use; its URI if it has none
  int64_t num_captured = 0;
  int64_t num_bad = 0;  ///< of these: short or otherwise malformed
  int64_t num_reconnects = 0;
  double fps = 0.0;             ///< Hz, captured, over the last second or so
  double clock_offset_s = 0.0;  ///< s, host time minus device time
  double clock_skew_ppm = 0.0;  ///< how much faster the host's clock runs
  int num_clock_steps = 0;      ///< times that one of the two was set or started anew
};

/// One good frame.
struct CameraFrame {
  CameraModel model;
  bool registered = false;         ///< depth lies in the colour camera's frame
  std::vector<uint16_t> depth_mm;  ///< width * height of the model; 0: no measurement
  int color_width = 0;             ///< px; 0: no colour
  int color_height = 0;            ///< px
  std::vector<uint8_t> color_rgb;
  int64_t utime = 0;           ///< us since the epoch, of the measurement
  int64_t device_time_us = 0;  ///< as the device stamped it
  int frame_index = 0;         ///< as the device counts
  std::string serial;
};

/// A depth camera that is searched for until it is found, and again whenever it is lost: unplugged,
/// or without a frame for some time. Once found it is looked for by its serial. One thread uses it.
class Openni2Camera {
 public:
  struct Options {
    DeviceSelector device;
    StreamRequest stream;
    std::optional<CameraModel> calibration;         ///< instead of the fields of view
    std::optional<BrownConrady> distortion;         ///< of the calibration; taken out of the depth
    std::chrono::milliseconds stall_timeout{1000};  ///< without a frame: stalled; 3 times: reopened
    std::chrono::milliseconds search_interval{500};  ///< between looks at the list of devices
    std::chrono::milliseconds retry_interval{2000};  ///< after a device refused to open
    /// Called by Grab() at every change of state.
    std::function<void(const CameraStatus&)> on_change;
  };

  /// Errors: a recording that is absent, is none, or can't be opened. An
  /// absent device is no error.
  static Result<std::unique_ptr<Openni2Camera>> Create(const Options& options,
                                                       std::unique_ptr<DepthDeviceApi> api);

  /// Goes on with whatever is to do, for `timeout` or a little longer (opening a device takes its
  /// time). Nothing: no frame yet, or a bad one.
  std::optional<CameraFrame> Grab(std::chrono::milliseconds timeout);

  /// Closes the device and searches again; a recording begins again.
  void Restart();
  /// As of DepthDevice. Errors besides: no device is open.
  Result<void> SetExposure(int exposure_us);
  Result<void> SetGain(int gain);

  [[nodiscard]] const CameraStatus& status() const { return status_; }

 private:
  Openni2Camera(const Options& options, std::unique_ptr<DepthDeviceApi> api);

  void SetState(CameraState state, const std::string& message);
  void Search(std::chrono::milliseconds timeout);
  [[nodiscard]] std::vector<std::string> Candidates(const std::vector<DeviceListing>& devices);
  Result<void> TryOpen(const std::string& uri);
  Result<void> Adopt(const std::string& uri, const StreamDetails& details);
  [[nodiscard]] std::string NoDeviceMessage(const std::vector<DeviceListing>& devices) const;
  void Close(CameraState state, const std::string& message);

  std::optional<CameraFrame> ReadFrame(std::chrono::milliseconds timeout);
  void NoFrame();
  void EndRecording();
  std::optional<CameraFrame> Convert(const RawFrame& raw, int64_t arrival_utime);
  int64_t RecordingTime(int64_t device_us);
  void CountFrame(int64_t now_us);
  [[nodiscard]] std::string Name() const;

  Options options_;
  std::unique_ptr<DepthDeviceApi> api_;
  CameraStatus status_;
  ClockFilter clock_;

  std::string wanted_serial_;                         // Empty: by the selector.
  std::map<std::string, std::string> known_serials_;  // By URI; only of devices that are listed.
  int64_t next_attempt_us_ = 0;                       // Monotonic.
  bool was_open_ = false;
  bool finished_ = false;  // The recording is over.

  std::unique_ptr<DepthDevice> device_;  // Null while searching.
  StreamDetails details_;
  CameraModel model_;
  std::vector<int32_t> undistortion_;  // Empty: none.
  int64_t last_frame_us_ = 0;          // Monotonic.
  int64_t fps_since_us_ = 0;           // Monotonic.
  int64_t fps_frames_ = 0;
  std::optional<int64_t> first_device_us_;  // Of a recording.
  int64_t first_utime_ = 0;                 // At first_device_us_.
  int64_t first_monotonic_us_ = 0;          // At first_device_us_.
};

}  // namespace vantage
