#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/camera_model.h"
#include "common/result.h"
#include "drivers/sim/scene.h"
#include "drivers/sim/sensor_model.h"
#include "drivers/sim/sim_arm.h"
#include "drivers/sim/sim_hand.h"
#include "nodes/config_reader.h"
#include "perception/calibration/calibration_target.h"

namespace vantage {

/// The simulated set-up: tables [sim], [sim.table], [sim.floor], [sim.board], [[sim.object]],
/// [sim.sensor], [sim.arm] and [sim.arm.hand_eye], and the folder of [models].
struct SimConfig {
  std::string serial = "SIM0001";     ///< of the simulated device
  std::string camera_name = "XTION";  ///< the <NAME> of CAMERA_<NAME>_TO_WORLD
  CameraModel camera;
  SimScene scene;  ///< its poses are the truth that reports compare with
  SensorModelParameters sensor;
  SimArmParameters arm;
  std::optional<SimHandParameters> hand;          ///< nothing: the arm carries the camera itself
  std::optional<CalibrationTarget> board_target;  ///< what is printed on scene.board
  std::filesystem::path models_folder;
};

/// The channel on which the simulated camera hears where it truly is.
std::string SimCameraPoseChannel(const std::string& camera_name, bool has_hand);

/// Reads all of it but meshes and print: objects have a model id and a pose, the board its pose.
/// What is wrong shows at config.Finish(), save what concerns several keys together, which is
/// returned here.
Result<SimConfig> ReadSimConfig(ConfigReader& config);

/// Loads the objects' meshes from the models' folder. Errors as LoadObjectModel.
Result<void> LoadSimMeshes(SimConfig* sim);

/// Reads, finishes the config (call it after reading what else there is to read; tables of others
/// are ignored), loads the meshes and draws the board's print.
Result<SimConfig> LoadSimConfig(ConfigReader& config);

}  // namespace vantage
