#include "tools/monitor/doctor_devices.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <system_error>

#include "common/format.h"
#include "drivers/v4l2/video_node.h"
#include "tools/monitor/shown_text.h"

namespace vantage {
namespace {

using Level = DoctorFinding::Level;

std::vector<VideoNode> VideoNodes(const SystemView& system) {
  return ListVideoNodes(
      {(system.root / "sys/class/video4linux").string(), (system.root / "dev").string()});
}

std::string JoinGroup(const SystemView& system, const std::filesystem::path& node) {
  return system.AsRoot(
             Format("usermod -aG %s %s", system.group_of(node).c_str(), system.user.c_str())) +
         "  # and log in anew";
}

// A depth camera that OpenNI2 or the kernel knows.
struct UsbCamera {
  std::string name;
  std::string vendor;
  std::filesystem::path node;  // In /dev/bus/usb.
  bool is_kinect = false;
};

std::optional<UsbCamera> ReadUsbCamera(const SystemView& system, const std::string& device) {
  const std::string folder = "sys/bus/usb/devices/" + device + "/";
  const std::string vendor = system.ReadLine(folder + "idVendor");
  const std::string product = system.ReadLine(folder + "idProduct");
  const bool is_kinect = vendor == "045e" && (product == "02ae" || product == "02bf");
  if (vendor != "1d27" && vendor != "2bc5" && !is_kinect) return std::nullopt;
  const int bus = std::atoi(system.ReadLine(folder + "busnum").c_str());
  const int number = std::atoi(system.ReadLine(folder + "devnum").c_str());
  UsbCamera camera;
  camera.name = is_kinect ? "Kinect" : vendor == "1d27" ? "Xtion or Carmine" : "Orbbec";
  camera.name += Format(" %s:%s", Shown(vendor, 8).c_str(), Shown(product, 8).c_str());
  camera.vendor = vendor;
  camera.node = system.root / Format("dev/bus/usb/%03d/%03d", bus, number);
  camera.is_kinect = is_kinect;
  return camera;
}

DoctorFinding CheckKinectModule(const SystemView& system, const std::vector<WantedCamera>& wanted) {
  const std::string modules = system.Read("proc/modules").value_or("");
  const bool is_loaded =
      modules.starts_with("gspca_kinect ") || modules.find("\ngspca_kinect ") != std::string::npos;
  const bool by_kernel = std::ranges::any_of(
      wanted, [](const WantedCamera& camera) { return camera.driver == "v4l2"; });
  const bool by_openni2 = std::ranges::any_of(wanted, [](const WantedCamera& camera) {
    return camera.driver == "openni2" && !camera.is_simulated;
  });
  if (by_openni2 && !by_kernel && is_loaded) {
    return {Level::kWrong,
            "Kinect's module",
            "gspca_kinect holds the device, and OpenNI2 can't open it",
            system.AsRoot("modprobe -r gspca_kinect")};
  }
  if (!by_kernel) return {Level::kOk, "Kinect's module", "no camera of [camera] needs it", ""};
  if (!is_loaded) {
    return {Level::kWrong,
            "Kinect's module",
            "gspca_kinect is not loaded, so the Kinect has no video node",
            system.AsRoot("modprobe gspca_kinect depth_mode=1")};
  }
  const std::string mode = system.ReadLine("sys/module/gspca_kinect/parameters/depth_mode");
  if (mode == "1" || mode == "Y") {
    return {Level::kOk, "Kinect's module", "gspca_kinect gives depth", ""};
  }
  return {
      Level::kWarning,
      "Kinect's module",
      "gspca_kinect gives color and no depth",
      system.AsRoot("echo options gspca_kinect depth_mode=1 >/etc/modprobe.d/vantage-kinect.conf; "
                    "modprobe -r gspca_kinect; modprobe gspca_kinect")};
}

bool IsOf(const VideoNode& node, const DeviceSelector& device, const SystemView& system) {
  if (device.kind == DeviceSelector::Kind::kSerial) return node.serial == device.value;
  const size_t colon = device.value.find(':');
  const std::string kind = device.value.substr(0, colon);
  const std::string name = colon == std::string::npos ? "" : device.value.substr(colon + 1);
  if (kind == "id") return std::ranges::find(node.ids, name) != node.ids.end();
  const std::string path = (system.root / name.substr(name.starts_with('/') ? 1 : 0)).string();
  return kind == "path" &&
         (node.path == path || std::ranges::find(node.link_paths, path) != node.link_paths.end());
}

DoctorFinding CheckV4l2Camera(const SystemView& system, const WantedCamera& camera) {
  const std::string subject = "camera " + camera.name;
  const std::string text = Shown(camera.device.Text());
  if (text.starts_with("bus:")) {
    return {Level::kUnknown, subject, "buses are told by open devices only", "vantage-v4l2 --list"};
  }
  const std::vector<VideoNode> nodes = VideoNodes(system);
  const bool is_there = camera.device.kind == DeviceSelector::Kind::kIndex
                            ? static_cast<size_t>(camera.device.index) < nodes.size()
                            : std::ranges::any_of(nodes, [&](const VideoNode& node) {
                                return IsOf(node, camera.device, system);
                              });
  if (is_there) return {Level::kOk, subject, text + " is there", ""};
  return {
      Level::kWrong,
      subject,
      Format(
          "there is no %s among %zu video nodes: cable, port, power", text.c_str(), nodes.size()),
      "vantage-v4l2 --list"};
}

DoctorFinding CheckOpenni2Camera(const WantedCamera& camera,
                                 const Result<std::vector<DeviceListing>>& devices) {
  using Kind = DeviceSelector::Kind;
  const std::string subject = "camera " + camera.name;
  const std::string text = Shown(camera.device.Text());
  if (camera.is_simulated) return {Level::kOk, subject, text + " is simulated", ""};
  if (camera.device.kind == Kind::kRecording) {
    const Result<void> sound = CheckRecording(camera.device.value);
    if (sound) return {Level::kOk, subject, text, ""};
    return {Level::kWrong,
            subject,
            sound.error().message,
            Format("ls -l '%s'", camera.device.value.c_str())};
  }
  if (!devices)
    return {Level::kWrong, subject, devices.error().message, "apt install libopenni2-0"};
  const bool is_there =
      camera.device.kind == Kind::kIndex
          ? static_cast<size_t>(camera.device.index) < devices->size()
          : std::ranges::any_of(*devices, [&camera](const DeviceListing& each) {
              return each.uri == camera.device.value || each.serial == camera.device.value;
            });
  if (is_there) return {Level::kOk, subject, text + " is there", ""};
  if (camera.device.kind == Kind::kSerial && !devices->empty()) {
    return {Level::kUnknown,
            subject,
            Format("serials are told by open devices only; there are %zu", devices->size()),
            "vantage-openni2 --list"};
  }
  return {Level::kWrong,
          subject,
          Format("there is no %s among %zu OpenNI2 devices: cable, port, power",
                 text.c_str(),
                 devices->size()),
          "lsusb; vantage-openni2 --list"};
}

}  // namespace

DoctorFindings CheckVideoNodes(const SystemView& system) {
  DoctorFindings findings;
  for (const VideoNode& node : VideoNodes(system)) {
    const std::string name = std::filesystem::path(node.path).filename().string();
    const std::string subject = "/dev/" + name;
    const int refused = system.access(node.path);
    if (refused == 0) {
      findings.push_back({Level::kOk, subject, Shown(node.name, 80) + " may be opened", ""});
    } else {
      findings.push_back(
          {Level::kWrong,
           subject,
           Format("%s can't be opened: %s", Shown(node.name, 80).c_str(), std::strerror(refused)),
           refused == EACCES ? JoinGroup(system, node.path) : ""});
    }
  }
  if (findings.empty()) {
    findings.push_back({Level::kOk, "video nodes", "the kernel has none", ""});
  }
  return findings;
}

DoctorFindings CheckUsbCameras(const SystemView& system, const std::vector<WantedCamera>& wanted) {
  DoctorFindings findings;
  bool has_kinect = false;
  for (const std::string& device : system.List("sys/bus/usb/devices")) {
    const std::optional<UsbCamera> camera = ReadUsbCamera(system, device);
    if (!camera) continue;
    has_kinect = has_kinect || camera->is_kinect;
    const int refused = system.access(camera->node);
    const std::string subject = "USB " + Shown(device, 20);
    if (refused == 0) {
      findings.push_back({Level::kOk, subject, camera->name + " may be opened", ""});
      continue;
    }
    std::error_code error;
    const bool has_rules =
        std::filesystem::exists(system.root / "lib/udev/rules.d/60-libopenni2-0.rules", error);
    const bool by_rules = camera->vendor == "1d27" && !has_rules;
    findings.push_back({Level::kWrong,
                        subject,
                        Format("%s can't be opened: %s%s",
                               camera->name.c_str(),
                               std::strerror(refused),
                               by_rules ? "; its udev rules are not installed; after that plug it "
                                          "in anew"
                                        : ""),
                        refused != EACCES ? ""
                        : by_rules        ? system.AsRoot("apt install libopenni2-0")
                                          : JoinGroup(system, camera->node)});
  }
  if (has_kinect) findings.push_back(CheckKinectModule(system, wanted));
  if (findings.empty())
    findings.push_back({Level::kOk, "USB cameras", "no depth camera is plugged in", ""});
  return findings;
}

DoctorFindings CheckWantedCameras(const SystemView& system,
                                  const std::vector<WantedCamera>& wanted) {
  DoctorFindings findings;
  std::optional<Result<std::vector<DeviceListing>>> devices;
  for (const WantedCamera& camera : wanted) {
    if (camera.driver == "v4l2") {
      findings.push_back(CheckV4l2Camera(system, camera));
      continue;
    }
    const bool is_device =
        !camera.is_simulated && camera.device.kind != DeviceSelector::Kind::kRecording;
    if (is_device && !devices) devices = system.openni2_devices();
    findings.push_back(CheckOpenni2Camera(camera, devices.value_or(std::vector<DeviceListing>{})));
  }
  return findings;
}

}  // namespace vantage
