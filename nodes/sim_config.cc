#include "nodes/sim_config.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "nodes/process.h"
#include "nodes/target_config.h"
#include "perception/model/object_model.h"

namespace vantage {
namespace {

using Table = ConfigReader::Table;

constexpr double kFarthest = 100.0;  // m

bool IsName(const std::string& text) {
  constexpr size_t kLongest = 64;
  if (text.empty() || text.size() > kLongest) return false;
  return text.find_first_not_of(
             "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") ==
         std::string::npos;
}

void ReadName(Table& table, const std::string& key, std::string* name) {
  table.Read(key, name);
  if (!IsName(*name)) table.Fail(key, "expected 1 to 64 of A-Z a-z 0-9 _ -");
}

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

void ReadRange(Table& table,
               const std::string& key,
               double unit,
               double lowest,
               double highest,
               double* from,
               double* to) {
  std::vector<double> numbers = {*from / unit, *to / unit};
  table.ReadNumbers(key, 2, lowest, highest, &numbers);
  if (numbers[0] > numbers[1]) table.Fail(key, "expected the lower bound first");
  *from = numbers[0] * unit;
  *to = numbers[1] * unit;
}

/// Nothing when its table is absent.
std::optional<SimPlane> ReadPlane(Table& sim, const std::string& key, SimPlane plane) {
  Table table = sim.Sub(key);
  if (!sim.Has(key)) return std::nullopt;
  std::vector<double> size = {plane.size.x(), plane.size.y()};
  std::vector<double> center = {plane.center.x(), plane.center.y()};
  table.Read("height_m", &plane.height, -kFarthest, kFarthest);
  table.ReadNumbers("size_m", 2, 0.01, kFarthest, &size);
  table.ReadNumbers("center_m", 2, -kFarthest, kFarthest, &center);
  plane.size = {size[0], size[1]};
  plane.center = {center[0], center[1]};
  return plane;
}

/// Returns whether there is any noise but what is switched on by itself.
bool ReadSensor(Table table, SensorModelParameters* sensor) {
  bool noise = true;
  table.Read("noise", &noise);
  if (!noise) sensor->SwitchAllOff();
  const std::pair<const char*, bool*> parts[] = {{"quantization", &sensor->quantization},
                                                 {"axial_noise", &sensor->axial_noise},
                                                 {"lateral_noise", &sensor->lateral_noise},
                                                 {"shadow", &sensor->shadow},
                                                 {"grazing_dropout", &sensor->grazing_dropout},
                                                 {"bias", &sensor->bias}};
  for (const auto& [key, part] : parts) table.Read(key, part);
  ReadRange(table, "range_m", 1.0, 0.1, 60.0, &sensor->nearest, &sensor->farthest);
  ReadIn(table, "baseline_mm", 1e-3, 1.0, 1000.0, &sensor->baseline);
  table.Read("disparity_step_px", &sensor->disparity_step, 1e-4, 10.0);
  table.Read("axial_sigma_px", &sensor->axial_sigma, 0.0, 10.0);
  table.Read("correlation_px", &sensor->correlation, 0.0, 20.0);
  table.Read("lateral_sigma_px", &sensor->lateral_sigma, 0.0, 4.0);
  ReadRange(table, "dropout_deg", kDegree, 0.0, 90.0, &sensor->dropout_start, &sensor->dropout_end);
  ReadIn(table, "bias_at_1m_mm", 1e-3, 0.0, 100.0, &sensor->bias_at_1m);
  table.Read("bias_period_s", &sensor->bias_period, 1.0, 1e6);
  return noise;
}

void ReadArm(Table table, SimArmParameters* arm) {
  std::vector<double> target = {arm->target.x(), arm->target.y(), arm->target.z()};
  table.ReadNumbers("target_m", 3, -kFarthest, kFarthest, &target);
  arm->target = {target[0], target[1], target[2]};
  ReadIn(table, "start_azimuth_deg", kDegree, -360.0, 360.0, &arm->start_azimuth);
  ReadIn(table, "start_elevation_deg", kDegree, 0.0, 89.0, &arm->start_elevation);
  table.Read("start_radius_m", &arm->start_radius, 0.05, 10.0);
  table.Read("speed_m_per_s", &arm->speed, 1e-3, 10.0);
  ReadIn(table, "turn_deg_per_s", kDegree, 0.1, 1000.0, &arm->turn_speed);
  ReadRange(table, "radius_m", 1.0, 0.05, 10.0, &arm->lowest_radius, &arm->highest_radius);
  ReadRange(
      table, "elevation_deg", kDegree, 0.0, 89.0, &arm->lowest_elevation, &arm->highest_elevation);
  table.Read("clearance_m", &arm->clearance, 0.0, 10.0);
}

/// Nothing when its table is absent: the arm then carries the camera itself.
std::optional<SimHandParameters> ReadHand(Table arm, uint64_t seed) {
  Table table = arm.Sub("hand_eye");
  if (!arm.Has("hand_eye")) return std::nullopt;
  SimHandParameters hand;
  hand.seed = seed;
  table.ReadPose(&hand.T_hand_camera);
  ReadIn(table, "robot_noise_mm", 1e-3, 0.0, 100.0, &hand.translation_sigma);
  ReadIn(table, "robot_noise_deg", kDegree, 0.0, 5.0, &hand.rotation_sigma);
  if (Result<void> sound = hand.Validate(); !sound) {
    table.Fail("position_m", sound.error().message);
  }
  return hand;
}

void ReadBoard(Table& sim, bool noise, SimConfig* config) {
  Table table = sim.Sub("board");
  if (!sim.Has("board")) return;
  SimBoard board;
  // On a table, face up: its z goes into it.
  board.T_world_board = Eigen::Translation3d(0.0, 0.0, 0.003) *
                        Eigen::AngleAxisd(180.0 * kDegree, Eigen::Vector3d::UnitX());
  table.ReadPose(&board.T_world_board);
  CalibrationTarget target;
  ReadTarget(table, &target);
  board.size = target.BoardSize();
  if (!noise) board.noise = 0.0;
  config->scene.board = std::move(board);
  config->board_target = target;
}

/// Draws what is printed on the board.
Result<void> DrawBoard(SimConfig* sim) {
  if (!sim->scene.board) return {};
  // Tags' cells and most gaps are whole pixels; neither must the image be larger than it helps.
  const double size = sim->board_target->size;
  constexpr double kLargest = 4096.0;  // px
  double pixels_per_size = 240.0;
  while (pixels_per_size > 30.0 &&
         pixels_per_size * sim->scene.board->size.maxCoeff() / size > kLargest) {
    pixels_per_size *= 0.5;
  }
  Result<GrayImage> print = DrawTarget(*sim->board_target, std::max(100.0, pixels_per_size / size));
  if (!print) return print.error();
  sim->scene.board->print = std::move(print).value();
  return {};
}

void ReadObjects(Table& sim, std::vector<SimObject>* objects) {
  for (Table table : sim.SubTables("object")) {
    SimObject object;
    table.Require("model");
    table.Read("model", &object.model_id);
    if (!object.model_id.empty() && !CheckModelId(object.model_id)) {
      table.Fail("model", "expected 1 to 64 of A-Z a-z 0-9 _ -, no leading -");
    }
    table.ReadPose(&object.T_world_object);
    objects->push_back(std::move(object));
  }
}

void ReadModelsFolder(ConfigReader& config, bool required, std::filesystem::path* folder) {
  Table root = config.Root();
  const bool read_by_other = root.WasAsked("models");
  Table models = root.Sub("models");
  if (required) models.Require("folder");
  models.ReadPath("folder", folder);
  if (!read_by_other) models.IgnoreAll();  // What estimators want of it.
}

}  // namespace

std::string SimCameraPoseChannel(const std::string& camera_name, bool has_hand) {
  return (has_hand ? "SIM_CAMERA_" : "CAMERA_") + camera_name + "_TO_WORLD";
}

Result<SimConfig> ReadSimConfig(ConfigReader& config) {
  SimConfig sim;
  Table root = config.Root();
  root.Require("sim");
  Table table = root.Sub("sim");
  int64_t seed = 1;
  table.Read("seed", &seed, 0, INT64_MAX);
  sim.sensor.seed = static_cast<uint64_t>(seed);
  ReadName(table, "serial", &sim.serial);
  ReadName(table, "camera", &sim.camera_name);
  sim.sensor.device_id = DeviceIdFromSerial(sim.serial);
  sim.scene.table = ReadPlane(table, "table", {});
  if (sim.scene.table) sim.arm.table_height = sim.scene.table->height;
  sim.scene.floor = ReadPlane(table, "floor", {.height = -0.75, .size = {6.0, 6.0}});
  ReadObjects(table, &sim.scene.objects);
  ReadModelsFolder(config, !sim.scene.objects.empty(), &sim.models_folder);
  const bool noise = ReadSensor(table.Sub("sensor"), &sim.sensor);
  ReadBoard(table, noise, &sim);
  ReadArm(table.Sub("arm"), &sim.arm);
  sim.hand = ReadHand(table.Sub("arm"), sim.sensor.seed);
  if (Result<void> sound = sim.sensor.Validate(); !sound) return sound.error();
  if (Result<void> sound = sim.arm.Validate(); !sound) return sound.error();
  return sim;
}

Result<void> LoadSimMeshes(SimConfig* sim) {
  std::map<std::string, TriangleMesh> meshes;
  for (SimObject& object : sim->scene.objects) {
    if (!meshes.contains(object.model_id)) {
      Result<ObjectModel> model = LoadObjectModel(sim->models_folder / object.model_id);
      if (!model) return model.error();
      meshes[object.model_id] = std::move(model->mesh);
    }
    object.mesh = meshes[object.model_id];
  }
  return {};
}

Result<SimConfig> LoadSimConfig(ConfigReader& config) {
  Result<SimConfig> sim = ReadSimConfig(config);
  IgnoreTablesOfOthers(config);
  // The file's own errors first: they name the line.
  if (Result<void> read = config.Finish(); !read) return read.error();
  if (!sim) return sim;
  if (Result<void> loaded = LoadSimMeshes(&*sim); !loaded) return loaded.error();
  if (Result<void> drawn = DrawBoard(&*sim); !drawn) return drawn.error();
  return sim;
}

}  // namespace vantage
