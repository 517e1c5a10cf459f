#include "drivers/v4l2/v4l2_api.h"

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>

#include "drivers/v4l2/v4l2_device.h"
#include "drivers/v4l2/video_mode.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// The node or link that is asked for; empty: another kind of name.
std::string PathOf(const DeviceSelector& device) {
  constexpr std::string_view kPath = "path:";
  if (device.kind == DeviceSelector::Kind::kUri) return device.value;
  const bool is_path =
      device.kind == DeviceSelector::Kind::kAlias && device.value.starts_with(kPath);
  return is_path ? device.value.substr(kPath.size()) : std::string();
}

// Whether it names a device with all its nodes.
bool MeansAllNodes(const DeviceSelector& device) {
  return device.kind == DeviceSelector::Kind::kSerial ||
         (device.kind == DeviceSelector::Kind::kAlias && device.value.starts_with("bus:"));
}

// Reads what inotify tells. True: something happened to a video device's node.
bool SawVideoNode(int watch) {
  alignas(inotify_event) std::array<char, 4096> buffer;
  const ssize_t size = read(watch, buffer.data(), buffer.size());
  bool saw = false;
  for (ssize_t at = 0; at + static_cast<ssize_t>(sizeof(inotify_event)) <= size;) {
    inotify_event event{};
    std::memcpy(&event, &buffer[static_cast<size_t>(at)], sizeof(event));
    const char* name = &buffer[static_cast<size_t>(at)] + sizeof(event);
    saw = saw || (event.len > 5 && std::strncmp(name, "video", 5) == 0);
    at += static_cast<ssize_t>(sizeof(event) + event.len);
  }
  return saw;
}

}  // namespace

V4l2Api::V4l2Api(const V4l2Options& options, const DeviceSelector& device, const VideoRoots& roots)
    : options_(options),
      selector_(device),
      path_(PathOf(device)),
      roots_(roots),
      watch_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
  // Of attributes too: udev gives a node to its group after it is there.
  if (watch_.is_open()) {
    inotify_add_watch(watch_.get(), roots_.dev.c_str(), IN_CREATE | IN_MOVED_TO | IN_ATTRIB);
  }
}

// Opening a node can wake its camera up, so each is asked once.
const V4l2Api::Answer& V4l2Api::Ask(const std::string& path) {
  struct stat status {};
  Identity identity{};
  if (stat(path.c_str(), &status) == 0) {
    identity = {status.st_ino,
                int64_t{status.st_ctim.tv_sec} * 1'000'000'000 + status.st_ctim.tv_nsec};
  }
  const auto found = asked_.find(path);
  if (found != asked_.end() && found->second.first == identity) return found->second.second;
  Answer answer;
  const Result<FileDescriptor> fd = OpenVideoNode(path);
  const Result<VideoCapability> capability =
      fd ? ReadCapability(fd->get(), path) : Result<VideoCapability>(fd.error());
  if (capability) {
    answer.captures = CheckCapture(*capability, path).ok();
    answer.bus = capability->bus;
  }
  if (capability && answer.captures) {
    const std::vector<VideoFormat> formats =
        ReadVideoFormats(fd->get(), capability->buffer_type(), 1, 1);
    answer.has_depth = std::ranges::any_of(
        formats, [](const VideoFormat& format) { return format.fourcc == V4L2_PIX_FMT_Z16; });
  }
  return (asked_[path] = {identity, std::move(answer)}).second;
}

std::vector<DeviceListing> V4l2Api::List() {
  entries_.clear();
  for (const VideoNode& node : ListVideoNodes(roots_)) {
    const Answer& answer = Ask(node.path);
    if (!answer.captures && node.path != path_) continue;
    Entry entry;
    entry.device = {node.path, node.name, node.serial, {"path:" + node.path}};
    std::vector<std::string>& aliases = entry.device.aliases;
    for (const std::string& link : node.link_paths) aliases.push_back("path:" + link);
    for (const std::string& id : node.ids) aliases.push_back("id:" + id);
    if (!answer.bus.empty()) aliases.push_back("bus:" + answer.bus);
    entry.key = node.serial.empty() ? answer.bus : node.serial;
    entry.role = node.role;
    entry.has_depth = answer.has_depth;
    // Before the first of its device that has none.
    auto place = entries_.end();
    if (entry.has_depth && !entry.key.empty()) {
      place = std::ranges::find_if(entries_, [&entry](const Entry& other) {
        return other.key == entry.key && !other.has_depth;
      });
    }
    entries_.insert(place, std::move(entry));
  }
  AddSelected();
  std::vector<DeviceListing> listing;
  for (const Entry& entry : entries_) {
    if (IsWanted(entry)) listing.push_back(entry.device);
  }
  return listing;
}

bool V4l2Api::IsWanted(const Entry& entry) const {
  const auto some_other = [&](const auto& is_better) {
    return !entry.key.empty() && std::ranges::any_of(entries_, [&](const Entry& other) {
      return other.key == entry.key && is_better(other);
    });
  };
  if (const auto role = roles_.find(entry.device.serial); role != roles_.end()) {
    return entry.role == role->second ||
           !some_other([&](const Entry& other) { return other.role == role->second; });
  }
  if (entry.has_depth || options_.pixel_format != "auto" || !MeansAllNodes(selector_)) return true;
  return !some_other([](const Entry& other) { return other.has_depth; });
}

void V4l2Api::AddSelected() {
  const std::string alias = "path:" + path_;
  struct stat status {};
  if (path_.empty() || stat(path_.c_str(), &status) != 0) return;
  std::error_code error;
  const std::string target = fs::canonical(path_, error).string();
  for (Entry& entry : entries_) {
    if (entry.device.uri != path_ && entry.device.uri != target) continue;
    std::vector<std::string>& aliases = entry.device.aliases;
    if (std::ranges::find(aliases, alias) == aliases.end()) aliases.push_back(alias);
    return;
  }
  Entry entry;
  entry.device = {path_, path_, {}, {alias}};
  entries_.push_back(std::move(entry));
}

std::vector<std::string> V4l2Api::ColorPaths(const std::string& depth_path) const {
  std::vector<std::string> paths;
  if (!options_.color_device) return paths;
  const DeviceSelector& selector = *options_.color_device;
  for (size_t i = 0; i < entries_.size(); ++i) {
    const DeviceListing& device = entries_[i].device;
    if (device.uri == depth_path) continue;
    const bool matches =
        selector.kind == DeviceSelector::Kind::kIndex ? i == static_cast<size_t>(selector.index)
        : selector.kind == DeviceSelector::Kind::kUri ? device.uri == selector.value
        : selector.kind == DeviceSelector::Kind::kSerial
            ? device.serial == selector.value
            : std::ranges::find(device.aliases, selector.value) != device.aliases.end();
    if (matches) paths.push_back(device.uri);
  }
  return paths;
}

Result<std::unique_ptr<CameraDevice>> V4l2Api::Open(const std::string& uri) {
  Entry entry;
  for (const Entry& each : entries_) {
    if (each.device.uri == uri) entry = each;
  }
  // A device without a serial is looked for by the selector again, and its list must not change.
  const auto on_start = [this, serial = entry.device.serial, role = entry.role] {
    if (!serial.empty()) roles_[serial] = role;
  };
  return V4l2Device::Open(uri, entry.device.serial, ColorPaths(uri), options_, on_start);
}

bool V4l2Api::WaitForDevice(std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (auto left = timeout; left.count() > 0; left = std::chrono::ceil<std::chrono::milliseconds>(
                                                  deadline - std::chrono::steady_clock::now())) {
    if (!watch_.is_open()) {
      Sleep(left);
      return false;
    }
    pollfd ready{watch_.get(), POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(left.count()));
    if (count == 0) return false;
    if (count > 0 && SawVideoNode(watch_.get())) return true;
  }
  return false;
}

}  // namespace vantage
