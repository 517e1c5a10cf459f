#include "drivers/v4l2/device_report.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <vector>

#include "common/format.h"
#include "drivers/v4l2/pixel_format.h"
#include "drivers/v4l2/v4l2_api.h"
#include "drivers/v4l2/v4l2_controls.h"
#include "drivers/v4l2/v4l2_ioctl.h"
#include "drivers/v4l2/video_mode.h"

namespace vantage {
namespace {

// "  name      text"
std::string Line(const std::string& name, const std::string& text) {
  std::string line = Format("  %-10s%s", name.c_str(), text.c_str());
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string NamesText(const VideoNode& node, const VideoCapability& capability, size_t index) {
  std::string names = Format("index:%zu", index);
  if (!node.serial.empty()) names += ", serial:" + node.serial;
  if (!capability.bus.empty()) names += ", bus:" + capability.bus;
  std::string text = Line("device", names);
  for (const std::string& id : node.ids) text += Line("", "id:" + id);
  for (const std::string& link : node.link_paths) {
    const bool is_told = std::ranges::any_of(
        node.ids, [&link](const std::string& id) { return link.ends_with("/" + id); });
    if (!is_told) text += Line("", "path:" + link);
  }
  return text;
}

std::string FormatsOf(int fd, uint32_t buffer_type) {
  // 0 x 0: of a range of sizes the rates of the largest.
  const std::vector<VideoFormat> formats = ReadVideoFormats(fd, buffer_type, 0, 0);
  std::string text = Line("formats", formats.empty() ? "none" : "");
  for (const VideoFormat& format : formats) {
    text += Format("    %-4s  %s", FourccText(format.fourcc).c_str(), format.description.c_str());
    if (FindPixelFormat(format.fourcc) == nullptr) text += ", not known here";
    // Most devices have the same for all.
    const auto same = std::ranges::find(formats, format.sizes, &VideoFormat::sizes);
    if (!format.sizes.empty() && &*same != &format) {
      text.append(", sizes and rates of ").append(FourccText(same->fourcc)).append("\n");
      continue;
    }
    text += "\n";
    for (const VideoSize& size : format.sizes) {
      text += Format("      %-10s  %s\n", SizeText(size).c_str(), RatesText(size).c_str());
    }
  }
  return text;
}

const char* TypeText(uint32_t type) {
  switch (type) {
    case V4L2_CTRL_TYPE_INTEGER:
    case V4L2_CTRL_TYPE_INTEGER64:
      return "number";
    case V4L2_CTRL_TYPE_BOOLEAN:
      return "switch";
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU:
      return "menu";
    case V4L2_CTRL_TYPE_BUTTON:
      return "button";
    case V4L2_CTRL_TYPE_BITMASK:
      return "bits";
    default:
      return "other";
  }
}

std::string ControlText(const V4l2Controls& controls, const V4l2Control& control, int width) {
  std::string text =
      Format("    %-*s  %-6s  ", width, control.name.c_str(), TypeText(control.type));
  const Result<int64_t> value = controls.Get(control);
  if (control.type == V4L2_CTRL_TYPE_BUTTON || value) text += control.RangeText();
  if (value) {
    text += Format(", default %lld, now %lld",
                   static_cast<long long>(control.initial),
                   static_cast<long long>(*value));
  }
  if ((control.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0) text += ", can only be read";
  if ((control.flags & V4L2_CTRL_FLAG_INACTIVE) != 0) text += ", inactive";
  text.erase(text.find_last_not_of(' ') + 1);
  return text + "\n";
}

std::string ControlsOf(int fd, const std::string& path) {
  const V4l2Controls controls(fd, path);
  std::string text = Line("controls", controls.all().empty() ? "none" : "");
  size_t width = 0;
  for (const V4l2Control& control : controls.all()) width = std::max(width, control.name.size());
  for (const V4l2Control& control : controls.all()) {
    text += ControlText(controls, control, static_cast<int>(width));
  }
  return text;
}

std::string Report(const VideoNode& node, size_t index) {
  const Result<FileDescriptor> fd = OpenVideoNode(node.path);
  const Result<VideoCapability> capability =
      fd ? ReadCapability(fd->get(), node.path) : Result<VideoCapability>(fd.error());
  std::string text = Format(
      "%s  %s\n", node.path.c_str(), capability ? capability->card.c_str() : node.name.c_str());
  if (!capability) return text + "  " + capability.error().message + "\n";
  const bool captures = CheckCapture(*capability, node.path).ok();
  if (captures) text += NamesText(node, *capability, index);
  std::string driver = capability->driver + " " + capability->version;
  if (!node.interface.empty()) driver += ", USB interface " + node.interface;
  text += Line("driver", driver);
  text += Line("can", capability->Words());
  if (!captures) return text;
  return text + FormatsOf(fd->get(), capability->buffer_type()) + ControlsOf(fd->get(), node.path);
}

}  // namespace

std::string ReportVideoDevices(const VideoRoots& roots) {
  V4l2Api api({}, {}, roots);
  const std::vector<DeviceListing> listing = api.List();
  std::string text;
  for (const VideoNode& node : ListVideoNodes(roots)) {
    const auto place = std::ranges::find(listing, node.path, &DeviceListing::uri);
    if (!text.empty()) text += "\n";
    text += Report(node, static_cast<size_t>(place - listing.begin()));
  }
  return text.empty() ? "no V4L2 device; check the cable and `lsusb`\n" : text;
}

}  // namespace vantage
