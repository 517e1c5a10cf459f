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
#include <utility>

#include "drivers/v4l2/v4l2_device.h"
#include "drivers/v4l2/video_mode.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

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

V4l2Api::V4l2Api(const V4l2Options& options, const std::string& path, const VideoRoots& roots)
    : options_(options),
      path_(path),
      roots_(roots),
      watch_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
  // Of attributes too: udev gives a node to its group after it is there.
  if (watch_.is_open()) {
    inotify_add_watch(watch_.get(), roots_.dev.c_str(), IN_CREATE | IN_MOVED_TO | IN_ATTRIB);
  }
}

// Opening a node can wake its camera up, so each is asked once.
const V4l2Api::Node& V4l2Api::Ask(const std::string& path) {
  struct stat status {};
  Identity identity{};
  if (stat(path.c_str(), &status) == 0) {
    identity = {status.st_ino,
                int64_t{status.st_ctim.tv_sec} * 1'000'000'000 + status.st_ctim.tv_nsec};
  }
  const auto found = asked_.find(path);
  if (found != asked_.end() && found->second.first == identity) return found->second.second;
  Node node;
  const Result<FileDescriptor> fd = OpenVideoNode(path);
  const Result<VideoCapability> capability =
      fd ? ReadCapability(fd->get(), path) : Result<VideoCapability>(fd.error());
  if (capability) {
    node.captures = CheckCapture(*capability, path).ok();
    node.bus = capability->bus;
  }
  if (capability && node.captures) {
    const std::vector<VideoFormat> formats =
        ReadVideoFormats(fd->get(), capability->buffer_type(), 1, 1);
    node.has_depth = std::ranges::any_of(formats, [](const VideoFormat& format) {
      const PixelFormat* pixel = FindPixelFormat(format.fourcc);
      return pixel != nullptr && pixel->fourcc == V4L2_PIX_FMT_Z16;
    });
  }
  return (asked_[path] = {identity, std::move(node)}).second;
}

std::vector<DeviceListing> V4l2Api::List() {
  std::vector<DeviceListing> listing;
  for (const VideoNode& node : ListVideoNodes(roots_)) {
    const Node& asked = Ask(node.path);
    if (!asked.captures && node.path != path_) continue;
    DeviceListing device{node.path, node.name, node.serial, {"path:" + node.path}};
    for (const std::string& link : node.link_paths) device.aliases.push_back("path:" + link);
    for (const std::string& id : node.ids) device.aliases.push_back("id:" + id);
    if (!asked.bus.empty()) device.aliases.push_back("bus:" + asked.bus);
    // Before the first color node of its device.
    auto place = listing.end();
    if (asked.has_depth && !node.serial.empty()) {
      place = std::ranges::find_if(listing, [&](const DeviceListing& other) {
        return other.serial == node.serial && !Ask(other.uri).has_depth;
      });
    }
    listing.insert(place, std::move(device));
  }
  AddSelected(&listing);
  listing_ = listing;
  return listing;
}

void V4l2Api::AddSelected(std::vector<DeviceListing>* listing) const {
  const std::string alias = "path:" + path_;
  struct stat status {};
  if (path_.empty() || stat(path_.c_str(), &status) != 0) return;
  std::error_code error;
  const std::string target = fs::canonical(path_, error).string();
  for (DeviceListing& device : *listing) {
    if (device.uri != path_ && device.uri != target) continue;
    if (std::ranges::find(device.aliases, alias) == device.aliases.end()) {
      device.aliases.push_back(alias);
    }
    return;
  }
  listing->push_back({path_, path_, {}, {alias}});
}

std::vector<std::string> V4l2Api::ColorPaths(const std::string& depth_path) const {
  std::vector<std::string> paths;
  if (!options_.color_device) return paths;
  const DeviceSelector& selector = *options_.color_device;
  for (size_t i = 0; i < listing_.size(); ++i) {
    const DeviceListing& device = listing_[i];
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
  const auto device = std::ranges::find(listing_, uri, &DeviceListing::uri);
  return V4l2Device::Open(
      uri, device == listing_.end() ? "" : device->serial, ColorPaths(uri), options_);
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
