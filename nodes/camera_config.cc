#include "nodes/camera_config.h"

#include <algorithm>
#include <cctype>

#include "common/format.h"
#include "nodes/camera_calibration.h"

namespace vantage {
namespace {

constexpr size_t kLongestName = 32;

bool IsCameraName(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName &&
         std::ranges::all_of(name, [](unsigned char c) {
           return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
         });
}

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// Names of the cameras of a driver; the key "driver" of all of them is read. `others`: what the
// others say.
std::vector<std::string> CamerasOf(ConfigReader::Table& cameras,
                                   const std::string& driver,
                                   std::string* others) {
  std::vector<std::string> names;
  for (const std::string& name : cameras.Keys()) {
    std::string its_driver = "openni2";
    std::string as_written = its_driver;
    cameras.Sub(name).Read("driver", &as_written);
    cameras.Sub(name).ReadChoice("driver", &its_driver, {"openni2", "v4l2"});
    if (its_driver == driver) {
      names.push_back(name);
    } else {
      *others += Format("; [camera.%s] has driver = \"%s\"", name.c_str(), as_written.c_str());
    }
  }
  return names;
}

Result<std::string> ChooseCamera(const std::vector<std::string>& names,
                                 const std::string& process_name,
                                 const std::string& driver,
                                 const std::string& others) {
  const std::string prefix = driver + "-";
  if (names.empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("the config has no [camera.<NAME>] with driver = \"%s\", expected one such "
                        "as [camera.XTION] with device = \"index:0\"%s",
                        driver.c_str(),
                        others.c_str())};
  }
  if (!process_name.starts_with(prefix)) return names.front();
  for (const std::string& name : names) {
    if (prefix + Lower(name) == process_name) return name;
  }
  std::string known;
  for (const std::string& name : names) known += (known.empty() ? "" : ", ") + prefix + Lower(name);
  return Error{ErrorCode::kNotFound,
               Format("the process name %s belongs to no [camera.<NAME>] of the config, expected "
                      "one of: %s",
                      process_name.c_str(),
                      known.c_str())};
}

Registration ReadRegistration(ConfigReader::Table& table) {
  std::string registration = "none";
  table.ReadChoice("registration", &registration, {"none", "depth_to_color", "color_to_depth"});
  if (registration == "depth_to_color") return Registration::kDepthToColor;
  return registration == "none" ? Registration::kNone : Registration::kColorToDepth;
}

PixelLayout ReadColorLayout(ConfigReader::Table& table) {
  std::string layout = "rgb";
  table.ReadChoice("color_encoding", &layout, {"rgb", "gray", "mjpeg"});
  if (layout == "rgb") return PixelLayout::kRgb8;
  return layout == "gray" ? PixelLayout::kGray8 : PixelLayout::kJpeg;
}

DepthCompression ReadCompression(ConfigReader::Table& table) {
  std::string compression = "vdc";
  table.ReadChoice("compression", &compression, {"vdc", "zlib", "none"});
  if (compression == "vdc") return DepthCompression::kVdc;
  return compression == "zlib" ? DepthCompression::kZlib : DepthCompression::kNone;
}

void ReadControls(ConfigReader::Table& table, CameraConfig* config) {
  if (!table.Has("controls")) return;
  ConfigReader::Table controls = table.Sub("controls");
  constexpr int64_t kLargest = int64_t{1} << 53;
  for (const std::string& name : controls.Keys()) {
    controls.Read(name, &config->controls[name], -kLargest, kLargest);
  }
}

void ReadStream(ConfigReader::Table& table, CameraConfig* config) {
  table.Read("width_px", &config->stream.width, 1, kMaxImageSide);
  table.Read("height_px", &config->stream.height, 1, kMaxImageSide);
  table.Read("fps", &config->stream.fps, 1, 1000);
  table.Read("color", &config->stream.color);
  config->stream.color_layout = ReadColorLayout(table);
  config->stream.registration = ReadRegistration(table);
  table.Read("stall_timeout_s", &config->stall_timeout_s, 0.1, 60.0);
  table.Read("rate_hz", &config->rate_hz, 0.0, 1000.0);
  config->compression = ReadCompression(table);
  ReadControls(table, config);
}

}  // namespace

Result<CameraConfig> ReadCameraConfig(ConfigReader& config,
                                      const std::string& process_name,
                                      const std::string& driver) {
  ConfigReader::Table cameras = config.Root().Sub("camera");
  std::string others;
  const std::vector<std::string> names = CamerasOf(cameras, driver, &others);
  Result<std::string> name = ChooseCamera(names, process_name, driver, others);
  if (!name) return name.error();
  if (!IsCameraName(*name)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("[camera.%s]: expected a name of 1 to %zu capitals, digits and '_', which "
                        "becomes part of the channels' names",
                        name->c_str(),
                        kLongestName)};
  }
  for (const std::string& other : cameras.Keys()) {
    if (other != *name) cameras.Sub(other).IgnoreAll();
  }

  CameraConfig result;
  result.name = *name;
  ConfigReader::Table table = cameras.Sub(*name);
  table.Require("device");
  std::string device = "index:0";
  table.Read("device", &device);
  const Result<DeviceSelector> selector = DeviceSelector::Parse(device);
  if (selector) {
    result.device = *selector;
    if (selector->kind == DeviceSelector::Kind::kRecording) {
      result.device.value = table.FromFolder(selector->value).string();
    }
  } else {
    table.Fail("device", selector.error().message);
  }
  ReadStream(table, &result);
  std::filesystem::path file;
  table.ReadPath("calibration", &file);
  if (file.empty()) return result;

  Result<CameraCalibration> calibration = LoadCameraCalibration(file);
  if (!calibration) return calibration.error();
  const bool recording = result.device.kind == DeviceSelector::Kind::kRecording;
  if (!recording && (calibration->intrinsics.camera.width != result.stream.width ||
                     calibration->intrinsics.camera.height != result.stream.height)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("calibration file %s is for %d x %d px, expected the %d x %d px of "
                        "[camera.%s]",
                        file.c_str(),
                        calibration->intrinsics.camera.width,
                        calibration->intrinsics.camera.height,
                        result.stream.width,
                        result.stream.height,
                        name->c_str())};
  }
  result.calibration = *calibration;
  return result;
}

}  // namespace vantage
