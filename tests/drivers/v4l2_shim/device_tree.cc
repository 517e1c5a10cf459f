#include "tests/drivers/v4l2_shim/device_tree.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

namespace vantage::v4l2_shim {
namespace {

namespace fs = std::filesystem;

struct Entry {
  bool is_link = false;
  std::string content;  // or where the link leads
  bool operator==(const Entry&) const = default;
};
using Entries = std::map<std::string, Entry>;

std::string Underscored(std::string text) {
  std::ranges::replace(text, ' ', '_');
  return text;
}

// As udev and the USB core lay them out.
void AddDevice(const Device& device, Entries* entries) {
  const std::string minor = std::to_string(device.number);
  std::string node = "video";
  node += minor;
  const std::string hub_port = std::to_string(device.port + 1);
  std::string port = "1-";
  port += hub_port;
  const std::string usb = "sys/devices/emulated/usb1/" + port + "/";
  const std::string interface = port + ":1.0";
  const std::string video = usb + interface + "/video4linux/" + node + "/";
  std::string device_number = "81:";
  device_number += minor;
  std::string uevent = "MAJOR=81\nMINOR=";
  uevent += minor + "\nDEVNAME=" + node;
  const auto file = [entries](const std::string& path, const std::string& text) {
    (*entries)[path] = {false, text + "\n"};
  };
  const auto link = [entries](const std::string& path, const std::string& target) {
    (*entries)[path] = {true, target};
  };
  file(usb + "idVendor", "1d6b");
  file(usb + "idProduct", "0102");
  file(usb + "manufacturer", "Emulated");
  file(usb + "product", device.card);
  file(usb + "busnum", "1");
  file(usb + "devpath", hub_port);
  if (!device.serial.empty()) file(usb + "serial", device.serial);
  file(usb + interface + "/bInterfaceClass", "0e");
  file(video + "name", device.card);
  file(video + "index", std::to_string(device.index));
  file(video + "dev", device_number);
  file(video + "uevent", uevent);
  link(video + "device", "../../../" + interface);
  const std::string from_sys = video.substr(4, video.size() - 5);
  link("sys/class/video4linux/" + node, "../../" + from_sys);
  link("sys/dev/char/" + device_number, "../../" + from_sys);
  std::string end = "-video-index";
  end += std::to_string(device.index);
  std::string id = "usb-Emulated_" + Underscored(device.card);
  if (!device.serial.empty()) id += '_' + Underscored(device.serial);
  link("dev/v4l/by-id/" + id + end, "../../" + node);
  link("dev/v4l/by-path/pci-0000:00:14.0-usb-0:" + hub_port + ":1.0" + end, "../../" + node);
  file("dev/" + node, "");
}

std::string Content(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void RemoveStale(const fs::path& root, const Entries& wanted) {
  std::vector<fs::path> stale;
  for (const char* part : {"dev", "sys"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / part)) {
      if (entry.is_directory() && !entry.is_symlink()) continue;
      const auto found = wanted.find(entry.path().lexically_relative(root));
      if (found == wanted.end()) stale.push_back(entry.path());
    }
  }
  for (const fs::path& path : stale) fs::remove(path);
}

void Write(const fs::path& path, const Entry& entry) {
  std::error_code none;
  if (entry.is_link) {
    if (fs::read_symlink(path, none) == entry.content) return;
    fs::remove(path);
    fs::create_directories(path.parent_path());
    fs::create_symlink(entry.content, path);
    return;
  }
  if (fs::is_regular_file(path, none) && Content(path) == entry.content) return;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << entry.content;
}

}  // namespace

void UpdateTree(const fs::path& root, const std::vector<Device>& devices) {
  Entries wanted;
  for (const Device& device : devices) AddDevice(device, &wanted);
  for (const char* folder : {"dev/v4l", "sys/class/video4linux", "state"}) {
    fs::create_directories(root / folder);
  }
  RemoveStale(root, wanted);
  // The system's folders before the links to nodes.
  for (auto entry = wanted.rbegin(); entry != wanted.rend(); ++entry) {
    Write(root / entry->first, entry->second);
  }
  for (const auto& entry : fs::directory_iterator(root / "state")) {
    const std::string stem = entry.path().stem();
    if (!wanted.contains("dev/" + stem)) fs::remove(entry.path());
  }
}

bool IsEmulatedPath(const std::string& path) {
  for (const char* prefix : {"/dev/video",
                             "/dev/v4l/",
                             "/sys/class/video4linux",
                             "/sys/dev/char/81:",
                             "/sys/devices/emulated"}) {
    if (path.starts_with(prefix)) return true;
  }
  return path == "/dev/v4l";
}

std::optional<int> NodeNumber(const std::string& path) {
  const std::string prefix = "/dev/video";
  if (!path.starts_with(prefix)) return std::nullopt;
  const std::string digits = path.substr(prefix.size());
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (digits.empty() || digits.size() > 3 || !std::ranges::all_of(digits, is_digit)) {
    return std::nullopt;
  }
  return std::stoi(digits);
}

}  // namespace vantage::v4l2_shim
