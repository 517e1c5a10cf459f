#include "command_module.h"

#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "drivers/sim/openni2_plugin.h"
#include "drivers/sim/sim_arm.h"

namespace vantage {
namespace {

std::mutex command_mutex;
std::optional<Pose> command_pose;
std::vector<SimFault> command_faults;
SimAbilities command_abilities;

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
  SimAbilities Abilities() override {
    const std::lock_guard lock(command_mutex);
    return command_abilities;
  }
};

// One device; as many as $VANTAGE_TEST_SERIALS names, with commas between, where it is set.
Result<std::vector<SimDeviceSetup>> MakeTestDevices() {
  const char* serials = std::getenv("VANTAGE_TEST_SERIALS");
  std::istringstream names(serials == nullptr ? kTestSerial : serials);
  std::vector<SimDeviceSetup> devices;
  for (std::string serial; std::getline(names, serial, ',');) {
    SimDeviceSetup& setup = devices.emplace_back();
    setup.serial = serial;
    setup.scene = TestScene();
    setup.sensor.SwitchAllOff();
    setup.source = std::make_unique<CommandSource>();
  }
  return devices;
}

class CommandDriver : public SimDriver {
 public:
  explicit CommandDriver(OniDriverServices* services) : SimDriver(services, MakeTestDevices) {}
};

}  // namespace
}  // namespace vantage

extern "C" {
void sim_test_set_pose(double azimuth, double elevation, double radius);
void sim_test_fault(int kind, double duration);
void sim_test_abilities(const vantage::SimAbilities* abilities);

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

__attribute__((visibility("default"))) void sim_test_abilities(
    const vantage::SimAbilities* abilities) {
  const std::lock_guard lock(vantage::command_mutex);
  vantage::command_abilities = *abilities;
}
}

#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete pointer
ONI_EXPORT_DRIVER(vantage::CommandDriver)
