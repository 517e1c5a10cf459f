#pragma once

#include <optional>
#include <string>

#include "drivers/camera/device_selector.h"
#include "drivers/v4l2/disparity_model.h"

namespace vantage {

/// What is asked of V4L2 devices beside a StreamRequest.
struct V4l2Options {
  std::string pixel_format = "auto";  ///< a name of PixelFormat; "auto": the best that fits
  int depth_unit_um = 1000;           ///< um, of Z16 and Y16: 1 to 1,000,000
  DisparityModel disparity;           ///< of Y10B
  std::optional<DeviceSelector> color_device;  ///< whose color comes beside the depth
};

}  // namespace vantage
