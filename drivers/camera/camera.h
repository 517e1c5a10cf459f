#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/camera/camera_calibration.h"
#include "drivers/camera/camera_device.h"
#include "drivers/camera/camera_frame.h"
#include "drivers/camera/device_selector.h"
#include "drivers/camera/rectification.h"
#include "drivers/clock/clock_filter.h"

namespace vantage {

/// A camera that is searched for until it is found, and again whenever it is lost: unplugged,
/// or without a frame for some time. Once found it is looked for by its serial. One thread uses it.
class Camera {
 public:
  struct Options {
    DeviceSelector device;
    StreamRequest stream;
    std::optional<CameraCalibration> calibration;   ///< instead of the fields of view
    std::chrono::milliseconds stall_timeout{1000};  ///< without a frame: stalled; 3 times: reopened
    std::chrono::milliseconds search_interval{500};  ///< between looks at the list of devices
    std::chrono::milliseconds retry_interval{2000};  ///< after a device refused to open
    /// Called by Grab() at every change of state.
    std::function<void(const CameraStatus&)> on_change;
  };

  /// Errors: a recording that is absent, is none, or can't be opened. An
  /// absent device is no error.
  static Result<std::unique_ptr<Camera>> Create(const Options& options,
                                                std::unique_ptr<CameraDeviceApi> api);

  /// Goes on with whatever is to do, for `timeout` or a little longer (opening a device takes its
  /// time). Nothing: no frame yet, or a bad one.
  std::optional<CameraFrame> Grab(std::chrono::milliseconds timeout);

  /// Closes the device and searches again; a recording begins again.
  void Restart();
  /// As of CameraDevice. Errors besides: no device is open.
  Result<void> SetExposure(int exposure_us);
  Result<void> SetGain(int gain);
  Result<void> SetControl(const std::string& name, int64_t value);

  [[nodiscard]] const CameraStatus& status() const { return status_; }

 private:
  Camera(const Options& options, std::unique_ptr<CameraDeviceApi> api);

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
  void CountMissed(int64_t index);
  void ReportFault(const std::string& fault);
  std::optional<CameraFrame> Convert(const RawFrame& raw, int64_t arrival_utime);
  void AddColor(const RawFrame& raw, CameraFrame* frame);
  int64_t RecordingTime(int64_t device_us);
  void CountFrame(int64_t now_us);
  [[nodiscard]] std::string Name() const;

  Options options_;
  std::unique_ptr<CameraDeviceApi> api_;
  CameraStatus status_;
  ClockFilter clock_;

  std::string wanted_serial_;                         // Empty: by the selector.
  std::map<std::string, std::string> known_serials_;  // By URI; only of devices that are listed.
  int64_t next_attempt_us_ = 0;                       // Monotonic.
  bool was_open_ = false;
  bool finished_ = false;  // The recording is over.

  std::unique_ptr<CameraDevice> device_;  // Null while searching.
  StreamDetails details_;
  std::optional<Rectification> rectification_;
  int64_t last_frame_us_ = 0;  // Monotonic.
  int64_t fps_since_us_ = 0;   // Monotonic.
  int64_t fps_frames_ = 0;
  int64_t last_index_ = -1;                 // As the device counts; -1: none yet.
  std::optional<int64_t> first_device_us_;  // Of a recording.
  int64_t first_utime_ = 0;                 // At first_device_us_.
  int64_t first_monotonic_us_ = 0;          // At first_device_us_.
};

}  // namespace vantage
