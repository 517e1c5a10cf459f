#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/lens_distortion.h"
#include "drivers/camera/camera_device.h"

namespace vantage {

/// In the order of camera_status_v2_t.
enum class CameraState { kSearching, kOpening, kStreaming, kStalled, kLost };

/// What a camera is doing.
struct CameraStatus {
  CameraState state = CameraState::kSearching;
  std::string message;  ///< why, in one sentence; empty when all is well
  std::string serial;   ///< of the device in use or last in use; its URI if it has none
  int64_t num_captured = 0;
  int64_t num_bad = 0;       ///< of these: short, marked as wrong, or otherwise malformed
  int64_t num_missed = 0;    ///< that the device counted and that never came
  int64_t num_unpaired = 0;  ///< depth images without the color that was asked for
  int64_t num_reconnects = 0;
  double fps = 0.0;             ///< Hz, captured, over the last second or so
  double color_delay_s = 0.0;   ///< s, how much later than its depth the last color was taken
  double clock_offset_s = 0.0;  ///< s, host time minus device time
  double clock_skew_ppm = 0.0;  ///< how much faster the host's clock runs
  int num_clock_steps = 0;      ///< times that one of the two was set or started anew
};

/// A color or gray image.
struct ColorImage {
  PixelLayout layout = PixelLayout::kRgb8;
  int width = 0;   ///< px
  int height = 0;  ///< px
  std::vector<uint8_t> data;
  int64_t utime = 0;  ///< us since the epoch, of the measurement
};

/// One good frame.
struct CameraFrame {
  int width = 0;                     ///< px, of depth; of color where there is no depth
  int height = 0;                    ///< px, alike
  std::optional<CameraModel> model;  ///< of width x height; nothing: no calibration
  LensDistortion distortion;         ///< left in the images; only of color without depth
  bool registered = false;           ///< depth and color show the same from pixel to pixel
  std::vector<uint16_t> depth_mm;    ///< width * height values, 0: no measurement; empty: no depth
  std::optional<ColorImage> color;
  int64_t utime = 0;           ///< us since the epoch, of the measurement
  int64_t device_time_us = 0;  ///< as the device stamped it
  std::string serial;
};

}  // namespace vantage
