#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/v4l2/v4l2_ioctl.h"
#include "drivers/v4l2/v4l2_options.h"
#include "drivers/v4l2/video_node.h"

namespace vantage {

/// CameraDeviceApi on the kernel's video4linux.
class V4l2Api : public CameraDeviceApi {
 public:
  /// @param path of a node or a link to one that is a device whatever it is, so that it is told
  /// why it is none; empty: those alone that sysfs has.
  V4l2Api(const V4l2Options& options, const std::string& path, const VideoRoots& roots = {});

  [[nodiscard]] std::string name() const override { return "V4L2"; }
  [[nodiscard]] std::string search_hint() const override {
    return "check the cable, `lsusb`, and `vantage-v4l2 --list`";
  }
  /// The nodes that capture images, or might: of each USB device those with depth first.
  std::vector<DeviceListing> List() override;
  Result<std::unique_ptr<CameraDevice>> Open(const std::string& uri) override;
  bool WaitForDevice(std::chrono::milliseconds timeout) override;

 private:
  // What an open node told.
  struct Node {
    bool captures = true;  // Or might: it could not be opened.
    bool has_depth = false;
    std::string bus;
  };
  // Tells a node from another that has its path later.
  using Identity = std::pair<ino_t, int64_t>;

  const Node& Ask(const std::string& path);
  void AddSelected(std::vector<DeviceListing>* listing) const;
  // That color_device may mean.
  [[nodiscard]] std::vector<std::string> ColorPaths(const std::string& depth_path) const;

  V4l2Options options_;
  std::string path_;
  VideoRoots roots_;
  std::map<std::string, std::pair<Identity, Node>> asked_;  // By path.
  std::vector<DeviceListing> listing_;                      // Of the last List().
  FileDescriptor watch_;                                    // Of the folder of nodes, by inotify.
};

}  // namespace vantage
