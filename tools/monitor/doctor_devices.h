#pragma once

#include <string>
#include <vector>

#include "drivers/camera/device_selector.h"
#include "tools/monitor/doctor_finding.h"
#include "tools/monitor/system_view.h"

namespace vantage {

/// A camera of the configuration.
struct WantedCamera {
  std::string name;    ///< the <NAME> of the channels
  std::string driver;  ///< "openni2" or "v4l2"
  DeviceSelector device;
  bool is_simulated = false;
};

/// Each node in /dev/video* that gives images: may this user open it?
DoctorFindings CheckVideoNodes(const SystemView& system);
/// Depth cameras on USB: may this user open them, and is the kernel's module as it must be?
DoctorFindings CheckUsbCameras(const SystemView& system, const std::vector<WantedCamera>& wanted);
/// Each camera of the configuration is there.
DoctorFindings CheckWantedCameras(const SystemView& system,
                                  const std::vector<WantedCamera>& wanted);

}  // namespace vantage
