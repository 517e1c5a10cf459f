#include "command_module.h"

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/sim/openni2_plugin.h"
#include "drivers/sim/sim_arm.h"

namespace vantage {
namespace {

std::mutex command_mutex;
std::optional<Pose> command_pose;
std::vector<SimFault> command_faults;

class CommandSource : public SimDeviceSource {
 public:
  std::optional<Pose> CameraPose() override {
    const std::lock_guard lock(command_mutex);
    return command_pose;
  }
  std::vector<SimFault> TakeFaults() override {
    const std::lock_guard lock(command_mutex);
    return std::exchange(command_faults, {});
  }
};

Result<std::optional<SimDeviceSetup>> MakeTestDevice() {
  SimDeviceSetup setup;
  setup.serial = kTestSerial;
  setup.scene = TestScene();
  setup.sensor.SwitchAllOff();
  setup.source = std::make_unique<CommandSource>();
  return std::optional<SimDeviceSetup>(std::move(setup));
}

class CommandDriver : public SimDriver {
 public:
  explicit CommandDriver(OniDriverServices* services) : SimDriver(services, MakeTestDevice) {}
};

}  // namespace
}  // namespace vantage

extern "C" {
void sim_test_set_pose(double azimuth, double elevation, double radius);
void sim_test_fault(int kind, double duration);

__attribute__((visibility("default"))) void sim_test_set_pose(double azimuth,
                                                              double elevation,
                                                              double radius) {
  const std::lock_guard lock(vantage::command_mutex);
  vantage::command_pose = vantage::ViewOnSphere(vantage::kTestTarget, azimuth, elevation, radius);
}

__attribute__((visibility("default"))) void sim_test_fault(int kind, double duration) {
  const std::lock_guard lock(vantage::command_mutex);
  vantage::command_faults.push_back({static_cast<vantage::SimFault::Kind>(kind), duration});
}
}

#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete pointer
ONI_EXPORT_DRIVER(vantage::CommandDriver)
