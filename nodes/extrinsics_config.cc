#include "nodes/extrinsics_config.h"

#include "nodes/target_config.h"

namespace vantage {
namespace {

using Table = ConfigReader::Table;

/// A number whose unit in the file is `unit` of ours.
void ReadIn(Table& table,
            const std::string& key,
            double unit,
            double lowest,
            double highest,
            double* value) {
  double number = *value / unit;
  table.Read(key, &number, lowest, highest);
  *value = number * unit;
}

void ReadNoise(Table& table, HandEyeNoise* noise) {
  ReadIn(table, "robot_noise_mm", 1e-3, 1e-3, 100.0, &noise->robot_translation);
  ReadIn(table, "robot_noise_deg", kDegree, 1e-4, 10.0, &noise->robot_rotation);
  table.Read("pixel_noise_px", &noise->pixel, 0.01, 10.0);
}

void ReadCheck(Table table, ExtrinsicsConfig* config) {
  DriftCheckParameters& check = config->check;
  table.Read("detections", &config->detections);
  ReadIn(table, "detection_noise_mm", 1e-3, 0.1, 100.0, &config->detection_sigma);
  table.Read("views", &check.window, 3, 1000);
  table.Read("least_views", &check.least_views, 1, 1000);
  table.Read("false_alarms", &check.false_alarms, 1e-9, 1.0);
  table.Read("distortion_ratio", &check.distortion_ratio, 1.0, 100.0);
}

void ReadLive(Table table, LiveCalibrationParameters* live) {
  ReadIn(table, "first_turn_deg", kDegree, 1.0, 45.0, &live->first_turn);
  table.Read("max_distance_m", &live->limits.distance, 0.01, 10.0);
  ReadIn(table, "max_turn_deg", kDegree, 1.0, 180.0, &live->limits.turn);
  ReadIn(table, "translation_bound_mm", 1e-3, 1e-3, 100.0, &live->translation_bound);
  ReadIn(table, "rotation_bound_deg", kDegree, 1e-4, 10.0, &live->rotation_bound);
  table.Read("least_views", &live->least_views, 4, 1000);
  table.Read("max_views", &live->max_views, 4, 1000);
  table.Read("patience_s", &live->patience_s, 1.0, 3600.0);
}

}  // namespace

Result<ExtrinsicsConfig> ReadExtrinsicsConfig(ConfigReader& config) {
  ExtrinsicsConfig read;
  config.Root().Require("extrinsics");
  Table table = config.Root().Sub("extrinsics");
  table.Read("camera", &read.camera);
  std::string setup = "eye-in-hand";
  table.ReadChoice("setup", &setup, {"eye-in-hand", "eye-to-hand"});
  if (setup == "eye-to-hand") read.setup = HandEyeSetup::kEyeToHand;
  table.Require("calibration");
  table.ReadPath("calibration", &read.calibration);
  table.Read("hand_channel", &read.hand_channel);
  ReadNoise(table, &read.noise);
  table.Sub("base").ReadPose(&read.T_world_base);
  const bool has_target = table.Has("target");
  Table target_table = table.Sub("target");
  if (has_target) {
    read.target.emplace();
    ReadTarget(target_table, &*read.target);
  }
  ReadCheck(table.Sub("check"), &read);
  ReadLive(table.Sub("live"), &read.live);
  read.check.noise = read.noise;
  if (Result<void> sound = read.check.Validate(); !sound) return sound.error();
  if (read.live.max_views < read.live.least_views) {
    return Error{ErrorCode::kInvalidArgument,
                 "[extrinsics.live] max_views is less than least_views"};
  }
  return read;
}

}  // namespace vantage
