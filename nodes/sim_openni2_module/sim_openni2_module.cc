// What OpenNI2 loads: the simulated camera that VANTAGE_SIM_CONFIG describes.
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "drivers/sim/openni2_plugin.h"
#include "nodes/sim_config.h"
#include "nodes/sim_openni2_module/bus_source.h"

namespace vantage {
namespace {

/// VANTAGE_SIM_CONFIG; empty when it is not set. OpenNI2 changes the working folder while it loads
/// plugins, so a relative path starts at the folder that the shell gave the program.
std::filesystem::path ConfigFile() {
  const char* file = std::getenv("VANTAGE_SIM_CONFIG");
  const char* folder = std::getenv("PWD");
  if (file == nullptr || *file == '\0') return {};
  return std::filesystem::path(folder == nullptr ? "" : folder) / file;
}

Result<std::vector<SimDeviceSetup>> DevicesFromEnvironment() {
  const std::filesystem::path file = ConfigFile();
  std::vector<SimDeviceSetup> devices;
  if (file.empty()) return devices;
  Result<ConfigReader> config = ConfigReader::Open(file);
  if (!config) return config.error();
  LiveBus::Options options;
  // As RunProcess reads it, so that plugin and processes meet on one bus.
  ConfigReader::Table bus = config->Root().Sub("bus");
  bus.Read("url", &options.url);
  bus.IgnoreAll();
  Result<SimConfig> sim = LoadSimConfig(*config);
  if (!sim) return sim.error();
  options.name = "sim-" + sim->serial;
  options.version = VANTAGE_VERSION;
  options.config_hash = config->Hash();
  // Poses and commands are small.
  options.receive_buffer_bytes = 1 << 20;
  Result<std::unique_ptr<BusSource>> source = BusSource::Create(
      options, SimCameraPoseChannel(sim->camera_name, sim->hand.has_value()), sim->serial);
  if (!source) return source.error();
  SimDeviceSetup& setup = devices.emplace_back();
  setup.serial = sim->serial;
  setup.camera = sim->camera;
  setup.scene = std::move(sim->scene);
  setup.sensor = sim->sensor;
  setup.source = std::move(*source);
  return devices;
}

class ModuleDriver : public SimDriver {
 public:
  explicit ModuleDriver(OniDriverServices* services)
      : SimDriver(services, DevicesFromEnvironment) {}
};

}  // namespace
}  // namespace vantage

#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete pointer
ONI_EXPORT_DRIVER(vantage::ModuleDriver)
