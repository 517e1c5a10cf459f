#include "drivers/v4l2/video_node.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "common/format.h"
#include "drivers/v4l2/v4l2_ioctl.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLongestText = 256;
constexpr int kDeepest = 8;  // folders from a video device up to its USB device

std::string Printable(std::string_view text, bool with_spaces) {
  std::string printable;
  for (const char c : text.substr(0, kLongestText)) {
    if (c == '\0') break;
    if ((c > ' ' && c <= '~') || (c == ' ' && with_spaces)) printable += c;
  }
  return printable;
}

// The first line of a file of sysfs; empty when there is none.
std::string ReadLine(const fs::path& file, bool with_spaces) {
  std::ifstream stream(file);
  std::string line(kLongestText, '\0');
  stream.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(static_cast<size_t>(stream.gcount()));
  return Printable(line.substr(0, line.find('\n')), with_spaces);
}

// N of "videoN".
std::optional<int> NumberOf(const std::string& name) {
  constexpr std::string_view kPrefix = "video";
  if (!name.starts_with(kPrefix)) return std::nullopt;
  int number = -1;
  const char* end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data() + kPrefix.size(), end, number);
  if (error != std::errc() || rest != end || number < 0) return std::nullopt;
  return number;
}

std::vector<fs::path> Entries(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    entries.push_back(at->path());
  }
  std::ranges::sort(entries);
  return entries;
}

// The folder of the USB device that a video device belongs to; empty: it is on no USB.
fs::path UsbFolder(const fs::path& video) {
  std::error_code error;
  fs::path folder = fs::canonical(video / "device", error);
  for (int i = 0; !error && i < kDeepest && folder.has_relative_path(); ++i) {
    if (fs::exists(folder / "idVendor", error)) return folder;
    folder = folder.parent_path();
  }
  return {};
}

// Names of links below /dev/v4l that lead to a node, by the node's name.
using Links = std::multimap<std::string, fs::path>;

Links ReadLinks(const fs::path& folder) {
  Links links;
  for (const fs::path& link : Entries(folder)) {
    std::error_code error;
    const fs::path target = fs::read_symlink(link, error);
    if (!error) links.emplace(target.filename().string(), link);
  }
  return links;
}

// A serial that two devices have, as cheap cameras do, tells none of them.
void ForgetSharedSerials(const std::vector<fs::path>& usb, std::vector<VideoNode>* nodes) {
  std::map<std::string, std::set<fs::path>> owners;
  for (size_t i = 0; i < nodes->size(); ++i) owners[(*nodes)[i].serial].insert(usb[i]);
  for (VideoNode& node : *nodes) {
    if (owners[node.serial].size() > 1) node.serial.clear();
  }
}

std::string Text(const unsigned char* bytes, size_t size) {
  return Printable({reinterpret_cast<const char*>(bytes), size}, true);
}

}  // namespace

std::vector<VideoNode> ListVideoNodes(const VideoRoots& roots) {
  std::map<int, fs::path> found;
  for (const fs::path& entry : Entries(roots.sys)) {
    if (const std::optional<int> number = NumberOf(entry.filename().string())) {
      found[*number] = entry;
    }
  }
  const Links ids = ReadLinks(fs::path(roots.dev) / "v4l/by-id");
  const Links paths = ReadLinks(fs::path(roots.dev) / "v4l/by-path");
  std::vector<VideoNode> nodes;
  std::vector<fs::path> usb;
  for (const auto& [number, folder] : found) {
    const std::string file_name = folder.filename().string();
    VideoNode node;
    node.path = (fs::path(roots.dev) / file_name).string();
    node.name = ReadLine(folder / "name", true);
    usb.push_back(UsbFolder(folder));
    if (!usb.back().empty()) {
      node.serial = ReadLine(usb.back() / "serial", false);
      std::error_code error;
      node.interface = fs::canonical(folder / "device", error).filename().string();
      node.role = node.interface.substr(node.interface.find(':') + 1);
      node.role.append("/").append(ReadLine(folder / "index", false));
    }
    for (auto [link, end] = ids.equal_range(file_name); link != end; ++link) {
      node.ids.push_back(link->second.filename().string());
      node.link_paths.push_back(link->second.string());
    }
    for (auto [link, end] = paths.equal_range(file_name); link != end; ++link) {
      node.link_paths.push_back(link->second.string());
    }
    nodes.push_back(std::move(node));
  }
  ForgetSharedSerials(usb, &nodes);
  return nodes;
}

uint32_t VideoCapability::buffer_type() const {
  if ((capabilities & V4L2_CAP_VIDEO_CAPTURE) != 0) return V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if ((capabilities & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0) {
    return V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  }
  return 0;
}

std::string VideoCapability::Words() const {
  const std::pair<uint32_t, const char*> words[] = {
      {V4L2_CAP_VIDEO_CAPTURE, "video capture"},
      {V4L2_CAP_VIDEO_CAPTURE_MPLANE, "video capture (multi-planar)"},
      {V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_VIDEO_OUTPUT_MPLANE, "video output"},
      {V4L2_CAP_VIDEO_M2M | V4L2_CAP_VIDEO_M2M_MPLANE, "memory to memory"},
      {V4L2_CAP_META_CAPTURE, "metadata capture"},
      {V4L2_CAP_META_OUTPUT, "metadata output"},
      {V4L2_CAP_VBI_CAPTURE | V4L2_CAP_SLICED_VBI_CAPTURE, "VBI capture"},
      {V4L2_CAP_VBI_OUTPUT | V4L2_CAP_SLICED_VBI_OUTPUT, "VBI output"},
      {V4L2_CAP_SDR_CAPTURE, "software radio"},
      {V4L2_CAP_TUNER, "tuner"},
      {V4L2_CAP_AUDIO, "audio"},
      {V4L2_CAP_READWRITE, "read/write"},
      {V4L2_CAP_STREAMING, "streaming"},
  };
  std::string text;
  for (const auto& [bits, word] : words) {
    if ((capabilities & bits) != 0) text += (text.empty() ? "" : ", ") + std::string(word);
  }
  return text.empty() ? "nothing that is known here" : text;
}

Result<VideoCapability> ReadCapability(int fd, const std::string& path) {
  v4l2_capability answer{};
  const int error = Ioctl(fd, VIDIOC_QUERYCAP, &answer);
  if (error == ENODEV) return SystemError(path, "can't be used", error);
  if (error != 0) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("device %s is no V4L2 device, expected one such as /dev/video0", path.c_str())};
  }
  VideoCapability capability;
  capability.driver = Text(answer.driver, sizeof(answer.driver));
  capability.card = Text(answer.card, sizeof(answer.card));
  capability.bus = Text(answer.bus_info, sizeof(answer.bus_info));
  capability.version = Format(
      "%u.%u.%u", answer.version >> 16, (answer.version >> 8) & 0xffU, answer.version & 0xffU);
  const bool own = (answer.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  capability.capabilities = own ? answer.device_caps : answer.capabilities;
  return capability;
}

Result<void> CheckCapture(const VideoCapability& capability, const std::string& path) {
  if (capability.buffer_type() != 0 && (capability.capabilities & V4L2_CAP_STREAMING) != 0) {
    return {};
  }
  return Error{ErrorCode::kInvalidArgument,
               Format("device %s (%s) can't stream images but does: %s; expected video capture "
                      "and streaming, which another node of the same device may have",
                      path.c_str(),
                      capability.card.c_str(),
                      capability.Words().c_str())};
}

}  // namespace vantage
