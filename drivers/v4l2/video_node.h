#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Where the kernel and udev tell of video devices.
struct VideoRoots {
  std::string sys = "/sys/class/video4linux";
  std::string dev = "/dev";
};

/// A node of a video device, as sysfs and udev's links describe it. A camera has several: for
/// depth, for color, for metadata.
struct VideoNode {
  std::string path;                     ///< "/dev/video0"
  std::string name;                     ///< the driver's
  std::string serial;                   ///< of the USB device; empty: none, or two devices have it
  std::string interface;                ///< "1-2:1.3", of the USB device
  std::string role;                     ///< which of the nodes of its USB device it is, at any port
  std::vector<std::string> ids;         ///< names in /dev/v4l/by-id
  std::vector<std::string> link_paths;  ///< in /dev/v4l, whole
};

/// By the number in their names. Empty where sysfs has none.
std::vector<VideoNode> ListVideoNodes(const VideoRoots& roots);

/// What VIDIOC_QUERYCAP says of a node.
struct VideoCapability {
  std::string driver;
  std::string card;  ///< maker and product
  std::string bus;
  std::string version;        ///< of the kernel's driver
  uint32_t capabilities = 0;  ///< of this node: V4L2_CAP_...

  /// V4L2_BUF_TYPE_VIDEO_CAPTURE or .._MPLANE; 0: it captures no images.
  [[nodiscard]] uint32_t buffer_type() const;
  /// "video capture, streaming"
  [[nodiscard]] std::string Words() const;
};

/// Errors: no V4L2 device.
Result<VideoCapability> ReadCapability(int fd, const std::string& path);

/// Errors: the node gives no images, or can't stream them.
Result<void> CheckCapture(const VideoCapability& capability, const std::string& path);

}  // namespace vantage
