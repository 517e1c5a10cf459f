#pragma once

#include <filesystem>
#include <string>

#include "common/camera_model.h"
#include "common/result.h"
#include "drivers/sim/scene.h"
#include "drivers/sim/sensor_model.h"
#include "drivers/sim/sim_arm.h"
#include "nodes/config_reader.h"

namespace vantage {

/// The simulated set-up: tables [sim], [sim.table], [sim.floor], [[sim.object]], [sim.sensor] and
/// [sim.arm], and the folder of [models].
struct SimConfig {
  std::string serial = "SIM0001";     ///< of the simulated device
  std::string camera_name = "XTION";  ///< the <NAME> of CAMERA_<NAME>_TO_WORLD
  CameraModel camera;
  SimScene scene;  ///< its poses are the truth that reports compare with
  SensorModelParameters sensor;
  SimArmParameters arm;
  std::filesystem::path models_folder;
};

/// Reads all of it but the meshes: objects have a model id and a pose. What is wrong shows at
/// config.Finish(), save what concerns several keys together, which is returned here.
Result<SimConfig> ReadSimConfig(ConfigReader& config);

/// Loads the objects' meshes from the models' folder. Errors as LoadObjectModel.
Result<void> LoadSimMeshes(SimConfig* sim);

/// Reads, finishes the config (call it after reading what else there is to read; tables of others
/// are ignored) and loads the meshes.
Result<SimConfig> LoadSimConfig(ConfigReader& config);

}  // namespace vantage
