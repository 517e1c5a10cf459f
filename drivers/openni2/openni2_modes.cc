#include "drivers/openni2/openni2_modes.h"

#include <array>
#include <cstdlib>

#include "common/format.h"

namespace vantage {
namespace {

using openni::VideoMode;

const char* FormatName(openni::PixelFormat format) {
  switch (format) {
    case openni::PIXEL_FORMAT_DEPTH_1_MM:
      return "1 mm";
    case openni::PIXEL_FORMAT_DEPTH_100_UM:
      return "0.1 mm";
    case openni::PIXEL_FORMAT_SHIFT_9_2:
    case openni::PIXEL_FORMAT_SHIFT_9_3:
      return "disparity";
    case openni::PIXEL_FORMAT_RGB888:
      return "RGB";
    case openni::PIXEL_FORMAT_YUV422:
    case openni::PIXEL_FORMAT_YUYV:
      return "YUV 4:2:2";
    case openni::PIXEL_FORMAT_GRAY8:
      return "8 bit gray";
    case openni::PIXEL_FORMAT_GRAY16:
      return "16 bit gray";
    case openni::PIXEL_FORMAT_JPEG:
      return "JPEG";
  }
  return "another format";
}

// How far a color mode is from what was asked for, the weightiest difference first.
using Distance = std::array<int64_t, 6>;

Distance DistanceOf(const VideoMode& mode, const StreamRequest& request) {
  const int64_t width = mode.getResolutionX();
  const int64_t height = mode.getResolutionY();
  const bool wants_gray = request.color_layout == PixelLayout::kGray8;
  const bool is_gray = mode.getPixelFormat() == openni::PIXEL_FORMAT_GRAY8;
  return {is_gray && !wants_gray ? 1 : 0,
          width != request.width || height != request.height ? 1 : 0,
          std::abs(mode.getFps() - request.fps),
          width < request.width || height < request.height ? 1 : 0,
          std::abs(width * height - int64_t{request.width} * request.height),
          is_gray != wants_gray ? 1 : 0};
}

}  // namespace

std::optional<VideoMode> FindDepthMode(const openni::SensorInfo& sensor,
                                       const StreamRequest& request) {
  const openni::Array<VideoMode>& modes = sensor.getSupportedVideoModes();
  for (const auto format : {openni::PIXEL_FORMAT_DEPTH_1_MM, openni::PIXEL_FORMAT_DEPTH_100_UM}) {
    for (int i = 0; i < modes.getSize(); ++i) {
      if (modes[i].getResolutionX() == request.width &&
          modes[i].getResolutionY() == request.height && modes[i].getFps() == request.fps &&
          modes[i].getPixelFormat() == format) {
        return modes[i];
      }
    }
  }
  return std::nullopt;
}

std::optional<VideoMode> FindColorMode(const openni::SensorInfo& sensor,
                                       const StreamRequest& request) {
  const openni::Array<VideoMode>& modes = sensor.getSupportedVideoModes();
  std::optional<VideoMode> nearest;
  for (int i = 0; i < modes.getSize(); ++i) {
    if (modes[i].getPixelFormat() != openni::PIXEL_FORMAT_RGB888 &&
        modes[i].getPixelFormat() != openni::PIXEL_FORMAT_GRAY8) {
      continue;
    }
    if (nearest && DistanceOf(*nearest, request) <= DistanceOf(modes[i], request)) continue;
    nearest = modes[i];
  }
  return nearest;
}

bool SameMode(const VideoMode& a, const VideoMode& b) {
  return a.getResolutionX() == b.getResolutionX() && a.getResolutionY() == b.getResolutionY() &&
         a.getFps() == b.getFps() && a.getPixelFormat() == b.getPixelFormat();
}

std::string ModeList(const openni::SensorInfo& sensor) {
  std::string list;
  const openni::Array<VideoMode>& modes = sensor.getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    list += Format("%s%dx%d at %d Hz in %s",
                   i == 0 ? "" : ", ",
                   modes[i].getResolutionX(),
                   modes[i].getResolutionY(),
                   modes[i].getFps(),
                   FormatName(modes[i].getPixelFormat()));
  }
  return list.empty() ? "none" : list;
}

}  // namespace vantage
