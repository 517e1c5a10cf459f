#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/format.h"
#include "drivers/v4l2/video_node.h"

namespace vantage {

/// Folders as sysfs and udev make them, in a temporary folder.
class FakeVideoFolders {
 public:
  FakeVideoFolders() {
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_ / "class/video4linux");
    std::filesystem::create_directories(root_ / "dev/v4l/by-id");
    std::filesystem::create_directories(root_ / "dev/v4l/by-path");
  }
  ~FakeVideoFolders() { std::filesystem::remove_all(root_); }
  FakeVideoFolders(const FakeVideoFolders&) = delete;
  FakeVideoFolders& operator=(const FakeVideoFolders&) = delete;

  [[nodiscard]] VideoRoots roots() const {
    return {(root_ / "class/video4linux").string(), (root_ / "dev").string()};
  }
  [[nodiscard]] std::string dev(const std::string& name) const { return root_ / "dev" / name; }

  /// A node whose device is the interface of a USB device, "1-2" for one; without: of none.
  void AddNode(const std::string& name,
               const std::string& words,
               const std::string& usb = "",
               int index = 0) {
    namespace fs = std::filesystem;
    const fs::path parent = usb.empty() ? root_ / "devices/platform/vivid.0"
                                        : root_ / "devices/pci/usb1" / usb / (usb + ":1.0");
    const fs::path video = parent / "video4linux" / name;
    fs::create_directories(video);
    std::ofstream(video / "name") << words << "\n";
    std::ofstream(video / "index") << index << "\n";
    fs::create_directory_symlink(parent, video / "device");
    fs::create_directory_symlink(video, root_ / "class/video4linux" / name);
    std::ofstream(dev(name)) << "no device";
  }
  void AddUsb(const std::string& usb, const std::string& serial) {
    const std::filesystem::path folder = root_ / "devices/pci/usb1" / usb;
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "idVendor") << "8086\n";
    if (!serial.empty()) std::ofstream(folder / "serial") << serial << "\n";
  }
  void AddLink(const std::string& folder, const std::string& link, const std::string& name) {
    std::filesystem::create_symlink("../../" + name, root_ / "dev/v4l" / folder / link);
  }

 private:
  std::filesystem::path root_ =
      std::filesystem::path(testing::TempDir()) / Format("fake_video_folders.%d", getpid());
};

}  // namespace vantage
