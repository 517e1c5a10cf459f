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
  /// @param device that is asked for. A path of a node, or of a link to one, is listed whatever it
  /// is, so that it is told why it is no camera. Of one chosen by serial or bus, the nodes
  /// without depth are left out where it has others and the options leave the format open.
  V4l2Api(const V4l2Options& options, const DeviceSelector& device, const VideoRoots& roots = {});

  [[nodiscard]] std::string name() const override { return "V4L2"; }
  [[nodiscard]] std::string search_hint() const override {
    return "check the cable, `lsusb`, and `vantage-v4l2 --list`";
  }
  /// The nodes that capture images, or might: of each USB device those with depth first, and that
  /// alone that has streamed, once one has.
  std::vector<DeviceListing> List() override;
  Result<std::unique_ptr<CameraDevice>> Open(const std::string& uri) override;
  bool WaitForDevice(std::chrono::milliseconds timeout) override;

 private:
  // What an open node told.
  struct Answer {
    bool captures = true;  // Or might: it could not be opened.
    bool has_depth = false;
    std::string bus;
  };
  // Tells a node from another that has its path later.
  using Identity = std::pair<ino_t, int64_t>;
  // A device of the list, and what else is known of it.
  struct Entry {
    DeviceListing device;
    std::string key;   // The same for all nodes of a USB device.
    std::string role;  // As of VideoNode.
    bool has_depth = false;
  };

  const Answer& Ask(const std::string& path);
  void AddSelected();
  [[nodiscard]] bool IsWanted(const Entry& entry) const;
  // That color_device may mean.
  [[nodiscard]] std::vector<std::string> ColorPaths(const std::string& depth_path) const;

  V4l2Options options_;
  DeviceSelector selector_;
  std::string path_;  // That the selector names; empty: none.
  VideoRoots roots_;
  std::map<std::string, std::pair<Identity, Answer>> asked_;  // By path.
  std::map<std::string, std::string> roles_;                  // That streamed, by serial.
  std::vector<Entry> entries_;  // Of the last List(), with those left out.
  FileDescriptor watch_;        // Of the folder of nodes, by inotify.
};

}  // namespace vantage
