#include "tests/drivers/v4l2_shim/control_table.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>

namespace vantage::v4l2_shim {

std::span<const KnownControl> KnownControls() {
  constexpr uint32_t kInteger = V4L2_CTRL_TYPE_INTEGER;
  constexpr uint32_t kBoolean = V4L2_CTRL_TYPE_BOOLEAN;
  constexpr uint32_t kMenu = V4L2_CTRL_TYPE_MENU;
  constexpr uint32_t kTitle = V4L2_CTRL_TYPE_CTRL_CLASS;
  static const std::array<KnownControl, 15> kControls = {{
      {"", V4L2_CID_USER_CLASS, "User Controls", kTitle, {}, nullptr, 0},
      {"brightness", V4L2_CID_BRIGHTNESS, "Brightness", kInteger, {}, nullptr, 0},
      {"contrast", V4L2_CID_CONTRAST, "Contrast", kInteger, {}, nullptr, 0},
      {"saturation", V4L2_CID_SATURATION, "Saturation", kInteger, {}, nullptr, 0},
      {"white_balance_automatic",
       V4L2_CID_AUTO_WHITE_BALANCE,
       "White Balance, Automatic",
       kBoolean,
       {},
       nullptr,
       0},
      {"gain", V4L2_CID_GAIN, "Gain", kInteger, {}, nullptr, 0},
      {"power_line_frequency",
       V4L2_CID_POWER_LINE_FREQUENCY,
       "Power Line Frequency",
       kMenu,
       {"Disabled", "50 Hz", "60 Hz"},
       nullptr,
       0},
      {"white_balance_temperature",
       V4L2_CID_WHITE_BALANCE_TEMPERATURE,
       "White Balance Temperature",
       kInteger,
       {},
       "white_balance_automatic",
       0},
      {"sharpness", V4L2_CID_SHARPNESS, "Sharpness", kInteger, {}, nullptr, 0},
      {"backlight_compensation",
       V4L2_CID_BACKLIGHT_COMPENSATION,
       "Backlight Compensation",
       kInteger,
       {},
       nullptr,
       0},
      {"", V4L2_CID_CAMERA_CLASS, "Camera Controls", kTitle, {}, nullptr, 0},
      {"auto_exposure",
       V4L2_CID_EXPOSURE_AUTO,
       "Auto Exposure",
       kMenu,
       {"Auto Mode", "Manual Mode", "Shutter Priority Mode", "Aperture Priority Mode"},
       nullptr,
       0},
      {"exposure_time_absolute",
       V4L2_CID_EXPOSURE_ABSOLUTE,
       "Exposure Time, Absolute",
       kInteger,
       {},
       "auto_exposure",
       V4L2_EXPOSURE_MANUAL},
      {"focus_absolute",
       V4L2_CID_FOCUS_ABSOLUTE,
       "Focus, Absolute",
       kInteger,
       {},
       "focus_automatic_continuous",
       0},
      {"focus_automatic_continuous",
       V4L2_CID_FOCUS_AUTO,
       "Focus, Automatic Continuous",
       kBoolean,
       {},
       nullptr,
       0},
  }};
  return kControls;
}

const KnownControl* FindControl(uint32_t id) {
  const auto found = std::ranges::find(KnownControls(), id, &KnownControl::id);
  return found == KnownControls().end() ? nullptr : &*found;
}

const KnownControl* FindControl(const std::string& name) {
  if (name.empty()) return nullptr;
  const auto found = std::ranges::find(KnownControls(), name, &KnownControl::name);
  return found == KnownControls().end() ? nullptr : &*found;
}

}  // namespace vantage::v4l2_shim
