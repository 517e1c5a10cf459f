#include "tests/kernel/vivid_device.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

namespace vantage {
namespace {

void Check(int result, const std::string& what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
}

void WriteDriverFile(const std::string& name) {
  std::ofstream file("/sys/bus/platform/drivers/vivid/" + name);
  file << "vivid.0" << std::flush;
  if (!file) throw std::system_error(errno, std::generic_category(), name + " vivid.0");
}

}  // namespace

VividDevice::VividDevice(const std::string& path) : file_(open(path.c_str(), O_RDWR | O_CLOEXEC)) {
  Check(file_, path);
}

VividDevice::~VividDevice() { close(file_); }

uint32_t VividDevice::Find(const std::string& control) const {
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (ioctl(file_, VIDIOC_QUERYCTRL, &query) == 0) {
    if (control == reinterpret_cast<const char*>(query.name)) return query.id;
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  throw std::system_error(ENOENT, std::generic_category(), "control " + control);
}

void VividDevice::Set(const std::string& control, int value) {
  v4l2_control request{Find(control), value};
  Check(ioctl(file_, VIDIOC_S_CTRL, &request), "setting " + control);
}

int VividDevice::Get(const std::string& control) const {
  v4l2_control request{Find(control), 0};
  Check(ioctl(file_, VIDIOC_G_CTRL, &request), "reading " + control);
  return request.value;
}

void VividDevice::Reset() {
  constexpr int kNoText = 2;
  Set("Test Pattern", 0);
  Set("OSD Text Mode", kNoText);
  Set("Brightness", 128);
  Set("Contrast", 128);
  Set("Percentage of Dropped Buffers", 0);
  Set("Wrap Sequence Number", 0);
  Set("Wrap Timestamp", 0);
}

void VividDevice::TakeStream() {
  v4l2_requestbuffers request{};
  request.count = 2;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  Check(ioctl(file_, VIDIOC_REQBUFS, &request), "allocating buffers");
}

std::vector<uint8_t> VividDevice::ReadFrame(uint32_t pixel_format, int width, int height) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<uint32_t>(width);
  format.fmt.pix.height = static_cast<uint32_t>(height);
  format.fmt.pix.pixelformat = pixel_format;
  Check(ioctl(file_, VIDIOC_S_FMT, &format), "setting the format");
  std::vector<uint8_t> frame(format.fmt.pix.sizeimage);
  const ssize_t size = read(file_, frame.data(), frame.size());
  Check(static_cast<int>(size), "reading a frame");
  frame.resize(static_cast<size_t>(size));
  return frame;
}

std::string VividDevice::bus() const {
  v4l2_capability capability{};
  Check(ioctl(file_, VIDIOC_QUERYCAP, &capability), "asking for capabilities");
  return reinterpret_cast<const char*>(capability.bus_info);
}

void UnbindVivid() { WriteDriverFile("unbind"); }
void BindVivid() { WriteDriverFile("bind"); }

}  // namespace vantage
