#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A setting of a device.
struct V4l2Control {
  uint32_t id = 0;     ///< V4L2_CID_...
  uint32_t type = 0;   ///< V4L2_CTRL_TYPE_...
  uint32_t flags = 0;  ///< V4L2_CTRL_FLAG_...
  std::string name;    ///< as v4l2-ctl has it: "white_balance_automatic"
  int64_t lowest = 0;
  int64_t highest = 0;
  uint64_t step = 1;
  int64_t initial = 0;                   ///< the default
  std::map<int64_t, std::string> items;  ///< of a menu, by what is set to choose them

  /// Errors: one that can't be set, or a value that it does not take, with those that it does.
  [[nodiscard]] Result<void> CheckValue(int64_t value) const;
  /// "1 to 255 in steps of 2", "0 or 1", "one of 0 (Disabled), 1 (50 Hz)"
  [[nodiscard]] std::string RangeText() const;
};

/// "Exposure, Auto" becomes "exposure_auto": letters and digits in lower case, '_' for all between.
std::string ControlName(const std::string& words);

/// The settings of an open device. `fd` outlives it.
class V4l2Controls {
 public:
  V4l2Controls(int fd, const std::string& path);

  [[nodiscard]] const std::vector<V4l2Control>& all() const { return controls_; }
  /// Errors: the device does not tell.
  [[nodiscard]] Result<int64_t> Get(const V4l2Control& control) const;
  /// As of CameraDevice. By what they are and not by their names, which differ between kernels.
  Result<void> Set(const std::string& name, int64_t value);
  Result<void> SetExposure(int exposure_us);
  Result<void> SetGain(int gain);

 private:
  [[nodiscard]] const V4l2Control* Find(uint32_t id) const;
  Result<void> Write(const V4l2Control& control, int64_t value);
  /// The first of `values` that the control takes.
  Result<void> WriteFirst(const V4l2Control& control, const std::vector<int64_t>& values);

  int fd_;
  std::string path_;
  std::vector<V4l2Control> controls_;
};

}  // namespace vantage
