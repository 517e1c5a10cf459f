#include "drivers/v4l2/v4l2_controls.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <string_view>

#include "common/format.h"
#include "drivers/v4l2/v4l2_ioctl.h"

namespace vantage {
namespace {

// A driver that never says "no more" must not be asked for ever.
constexpr size_t kMostControls = 1024;
constexpr int64_t kMostItems = 256;

constexpr int kExposureUnitUs = 100;  // of V4L2_CID_EXPOSURE_ABSOLUTE

bool IsMenu(uint32_t type) {
  return type == V4L2_CTRL_TYPE_MENU || type == V4L2_CTRL_TYPE_INTEGER_MENU;
}

bool IsNumber(uint32_t type) {
  return type == V4L2_CTRL_TYPE_INTEGER || type == V4L2_CTRL_TYPE_BOOLEAN || IsMenu(type) ||
         type == V4L2_CTRL_TYPE_BUTTON || type == V4L2_CTRL_TYPE_INTEGER64 ||
         type == V4L2_CTRL_TYPE_BITMASK;
}

template <size_t size, class Char>
std::string Words(const Char (&text)[size]) {
  std::string words;
  for (const Char c : text) {
    if (c == 0) break;
    if (c >= ' ' && c <= '~') words += static_cast<char>(c);
  }
  return words;
}

std::map<int64_t, std::string> ReadItems(int fd, const V4l2Control& control) {
  std::map<int64_t, std::string> items;
  const int64_t first = std::max<int64_t>(control.lowest, 0);
  for (int64_t i = first; i <= control.highest && i - first < kMostItems; ++i) {
    v4l2_querymenu query{};
    query.id = control.id;
    query.index = static_cast<uint32_t>(i);
    if (Ioctl(fd, VIDIOC_QUERYMENU, &query) != 0) continue;  // Menus have gaps.
    items[i] = control.type == V4L2_CTRL_TYPE_MENU
                   ? Words(query.name)
                   : Format("%lld", static_cast<long long>(query.value));
  }
  return items;
}

}  // namespace

std::string ControlName(const std::string& words) {
  std::string name;
  bool gap = false;
  for (const char c : words) {
    const unsigned char byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) == 0) {
      gap = !name.empty();
      continue;
    }
    if (gap) name += '_';
    gap = false;
    name += static_cast<char>(std::tolower(byte));
  }
  return name;
}

Result<void> V4l2Control::CheckValue(int64_t value) const {
  const auto refuse = [this](const std::string& expected) {
    return Error{ErrorCode::kInvalidArgument, expected};
  };
  if ((flags & V4L2_CTRL_FLAG_READ_ONLY) != 0) return refuse("it can only be read");
  if (!IsNumber(type)) return refuse("it takes no number");
  if (type == V4L2_CTRL_TYPE_BUTTON) return {};
  bool fits = value >= lowest && value <= highest;
  if (IsMenu(type)) fits = items.contains(value);
  if (type == V4L2_CTRL_TYPE_BITMASK) {
    fits = value >= 0 && (static_cast<uint64_t>(value) & ~static_cast<uint64_t>(highest)) == 0;
  } else if (fits && step > 1) {
    fits = (static_cast<uint64_t>(value) - static_cast<uint64_t>(lowest)) % step == 0;
  }
  if (fits) return {};
  return refuse("expected " + RangeText());
}

std::string V4l2Control::RangeText() const {
  if (type == V4L2_CTRL_TYPE_BUTTON) return "any number, which presses it";
  if (type == V4L2_CTRL_TYPE_BOOLEAN) return "0 or 1";
  if (type == V4L2_CTRL_TYPE_BITMASK) {
    return Format("bits of 0x%llx", static_cast<unsigned long long>(highest));
  }
  if (IsMenu(type)) {
    std::string text = "one of";
    for (const auto& [value, words] : items) {
      text += Format("%s %lld (%s)",
                     text.size() == 6 ? "" : ",",
                     static_cast<long long>(value),
                     words.c_str());
    }
    return text;
  }
  std::string text =
      Format("%lld to %lld", static_cast<long long>(lowest), static_cast<long long>(highest));
  if (step > 1) text += Format(" in steps of %llu", static_cast<unsigned long long>(step));
  return text;
}

V4l2Controls::V4l2Controls(int fd, const std::string& path) : fd_(fd), path_(path) {
  uint32_t id = 0;
  while (controls_.size() < kMostControls) {
    v4l2_query_ext_ctrl query{};
    query.id = id | V4L2_CTRL_FLAG_NEXT_CTRL;
    if (Ioctl(fd_, VIDIOC_QUERY_EXT_CTRL, &query) != 0 || query.id <= id) return;
    id = query.id;
    if ((query.flags & V4L2_CTRL_FLAG_DISABLED) != 0 || query.type == V4L2_CTRL_TYPE_CTRL_CLASS) {
      continue;
    }
    V4l2Control control;
    control.id = query.id;
    control.type = query.type;
    control.flags = query.flags;
    control.name = ControlName(Words(query.name));
    control.lowest = query.minimum;
    control.highest = query.maximum;
    control.step = query.step;
    control.initial = query.default_value;
    if (IsMenu(control.type)) control.items = ReadItems(fd_, control);
    controls_.push_back(std::move(control));
  }
}

const V4l2Control* V4l2Controls::Find(uint32_t id) const {
  const auto found = std::ranges::find(controls_, id, &V4l2Control::id);
  return found == controls_.end() ? nullptr : &*found;
}

Result<int64_t> V4l2Controls::Get(const V4l2Control& control) const {
  v4l2_ext_control value{};
  value.id = control.id;
  v4l2_ext_controls request{};
  request.which = V4L2_CTRL_WHICH_CUR_VAL;
  request.count = 1;
  request.controls = &value;
  if (!IsNumber(control.type) || (control.flags & V4L2_CTRL_FLAG_WRITE_ONLY) != 0) {
    return Error{ErrorCode::kUnavailable, "has no number"};
  }
  if (const int error = Ioctl(fd_, VIDIOC_G_EXT_CTRLS, &request); error != 0) {
    return SystemError(path_, "does not tell " + control.name, error);
  }
  return control.type == V4L2_CTRL_TYPE_INTEGER64 ? value.value64 : int64_t{value.value};
}

Result<void> V4l2Controls::Write(const V4l2Control& control, int64_t number) {
  const auto refuse = [&](const std::string& reason) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("device %s refuses %s = %lld: %s",
                        path_.c_str(),
                        control.name.c_str(),
                        static_cast<long long>(number),
                        reason.c_str())};
  };
  if (Result<void> fits = control.CheckValue(number); !fits) return refuse(fits.error().message);
  v4l2_ext_control value{};
  value.id = control.id;
  if (control.type == V4L2_CTRL_TYPE_INTEGER64) {
    value.value64 = number;
  } else {
    value.value = static_cast<int32_t>(number);
  }
  v4l2_ext_controls request{};
  request.which = V4L2_CTRL_WHICH_CUR_VAL;
  request.count = 1;
  request.controls = &value;
  const int error = Ioctl(fd_, VIDIOC_S_EXT_CTRLS, &request);
  if (error == 0) return {};
  if ((control.flags & V4L2_CTRL_FLAG_INACTIVE) != 0 || error == EACCES) {
    return refuse("another setting, such as an automatic one, has it in hand");
  }
  return refuse(SystemError(path_, "answers", error).message);
}

Result<void> V4l2Controls::WriteFirst(const V4l2Control& control,
                                      const std::vector<int64_t>& values) {
  for (const int64_t value : values) {
    if (control.CheckValue(value)) return Write(control, value);
  }
  return Write(control, values.front());
}

Result<void> V4l2Controls::Set(const std::string& name, int64_t value) {
  const auto found = std::ranges::find(controls_, name, &V4l2Control::name);
  if (found != controls_.end()) return Write(*found, value);
  std::string names;
  for (const V4l2Control& control : controls_) names += (names.empty() ? "" : ", ") + control.name;
  return Error{ErrorCode::kNotFound,
               Format("device %s has no control %s, expected one of: %s",
                      path_.c_str(),
                      name.c_str(),
                      names.empty() ? "none" : names.c_str())};
}

Result<void> V4l2Controls::SetExposure(int exposure_us) {
  const V4l2Control* automatic = Find(V4L2_CID_EXPOSURE_AUTO);
  if (exposure_us == 0) {
    if (automatic == nullptr) {
      return Error{ErrorCode::kNotFound,
                   Format("device %s has no automatic exposure", path_.c_str())};
    }
    return WriteFirst(
        *automatic,
        {V4L2_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY, V4L2_EXPOSURE_SHUTTER_PRIORITY});
  }
  const V4l2Control* exposure = Find(V4L2_CID_EXPOSURE_ABSOLUTE);
  if (exposure == nullptr) {
    return Error{ErrorCode::kNotFound,
                 Format("device %s has no exposure time in units of time", path_.c_str())};
  }
  const int64_t value = (int64_t{exposure_us} + kExposureUnitUs / 2) / kExposureUnitUs;
  if (value < exposure->lowest || value > exposure->highest) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("device %s refuses an exposure of %d us, expected %lld to %lld us in "
                        "steps of %llu",
                        path_.c_str(),
                        exposure_us,
                        static_cast<long long>(exposure->lowest) * kExposureUnitUs,
                        static_cast<long long>(exposure->highest) * kExposureUnitUs,
                        static_cast<unsigned long long>(std::max<uint64_t>(exposure->step, 1)) *
                            kExposureUnitUs)};
  }
  if (automatic != nullptr) {
    const Result<void> manual =
        WriteFirst(*automatic, {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY});
    if (!manual) return manual;
  }
  return Write(*exposure, value);
}

Result<void> V4l2Controls::SetGain(int gain) {
  const V4l2Control* control = Find(V4L2_CID_GAIN);
  if (control == nullptr) control = Find(V4L2_CID_ANALOGUE_GAIN);
  if (control == nullptr) {
    return Error{ErrorCode::kNotFound, Format("device %s has no gain", path_.c_str())};
  }
  if (const V4l2Control* automatic = Find(V4L2_CID_AUTOGAIN); automatic != nullptr) {
    if (Result<void> manual = Write(*automatic, 0); !manual) return manual;
  }
  return Write(*control, gain);
}

}  // namespace vantage
