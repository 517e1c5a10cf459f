#pragma once

#include <Driver/OniDriverAPI.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>

#include "common/camera_model.h"

namespace vantage {

/// The video modes of a sensor: full and half resolution at 30 fps.
std::array<OniVideoMode, 2> SimVideoModes(OniSensorType sensor, const CameraModel& camera);

/// One image stream of the simulated device, as OpenNI2 sees it.
class SimStream : public oni::driver::StreamBase {
 public:
  /// @param started called after the stream starts.
  SimStream(OniSensorType sensor, const CameraModel& camera, std::function<void()> started);

  OniStatus start() override;
  void stop() override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;
  OniBool isPropertySupported(int property) override;

  [[nodiscard]] OniSensorType sensor() const { return sensor_; }
  [[nodiscard]] bool started() const { return started_; }
  /// px, of the video mode.
  [[nodiscard]] int width();
  /// Hands a whole image of the video mode to OpenNI2, cropped and mirrored as was asked.
  /// @param pixels width * height pixels; `bytes` of them altogether.
  /// @param timestamp us since the device's start.
  /// @param is_short delivers only the first half of the bytes.
  void Deliver(const void* pixels, size_t bytes, uint64_t timestamp, int index, bool is_short);

 private:
  OniStatus SetCropping(const OniCropping& cropping);
  OniStatus SetVideoMode(const OniVideoMode& mode);
  [[nodiscard]] int BytesPerPixel() const { return sensor_ == ONI_SENSOR_DEPTH ? 2 : 3; }
  bool FillFrame(const uint8_t* pixels, size_t bytes, OniFrame* frame);
  void CopyPixels(const uint8_t* pixels, const OniFrame& frame) const;

  const OniSensorType sensor_;
  const CameraModel camera_;
  const std::function<void()> on_start_;
  std::atomic<bool> started_ = false;
  // Held while a frame is handed over, so that none comes after stop(); whoever hears of the frame
  // may call stop() on the same thread.
  std::recursive_mutex delivering_;
  std::mutex mutex_;  // Guards what follows.
  OniVideoMode mode_;
  OniCropping cropping_{};
  OniBool mirroring_ = FALSE;
};

}  // namespace vantage
