#include "nodes/fusion_config.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "common/format.h"
#include "nodes/confusion_config.h"
#include "nodes/models_config.h"
#include "nodes/planner_config.h"
#include "nodes/process.h"
#include "perception/model/enclosing_ball.h"
#include "perception/model/object_model.h"
#include "perception/model/symmetry_text.h"
#include "perception/verification/mesh_decimation.h"

namespace vantage {
namespace {

constexpr int kMostViews = 10'000;
constexpr size_t kMostLikelyPoses = 20;  // of a model; the widest take seconds each on fine grids

std::vector<std::string> FinalOrientationNames() {
  std::vector<std::string> names;
  for (const FinalOrientation each : kFinalOrientations) names.push_back(Name(each));
  return names;
}

// A table [[fusion.likely_pose]].
struct ModelsPose {
  ConfigReader::Table table;
  std::string model;
  LikelyPose pose;
};

std::vector<ModelsPose> ReadLikelyPoses(ConfigReader::Table fusion) {
  std::vector<ModelsPose> poses;
  for (ConfigReader::Table& table : fusion.SubTables("likely_pose")) {
    ModelsPose read{table, {}, {}};
    for (const char* key : {"model", "q_world_object", "spread_deg"}) table.Require(key);
    table.Read("model", &read.model);
    std::vector<double> wxyz;
    table.ReadNumbers("q_world_object", 4, -1.0, 1.0, &wxyz);
    if (!wxyz.empty()) {
      const Result<Eigen::Quaterniond> q =
          QuaternionFromWire(std::span<const double, 4>(wxyz.data(), 4));
      if (q) read.pose.q_world_object = *q;
      if (!q) table.Fail("q_world_object", q.error().message);
    }
    double spread_deg = 0.0;
    table.Read("spread_deg", &spread_deg, 0.1, 30.0);
    read.pose.spread = spread_deg * kDegree;
    table.Read("weight", &read.pose.weight, 0.0, 1e6);
    poses.push_back(std::move(read));
  }
  return poses;
}

// Errors wait for ConfigReader::Finish().
void GiveToModels(std::vector<ModelsPose> poses, std::map<std::string, TrackedModel>* models) {
  std::string in_use;
  for (const auto& [name, model] : *models) in_use += (in_use.empty() ? "" : ", ") + name;
  for (ModelsPose& each : poses) {
    const auto model = models->find(each.model);
    if (model == models->end()) {
      return each.table.Fail("model", "expected one of the models in use: " + in_use);
    }
    model->second.likely_poses.push_back(each.pose);
    if (model->second.likely_poses.size() > kMostLikelyPoses) {
      return each.table.Fail(
          "model", Format("expected at most %zu likely poses of a model", kMostLikelyPoses));
    }
  }
  for (ModelsPose& each : poses) {
    const bool none_counts =
        std::ranges::all_of(models->at(each.model).likely_poses,
                            [](const LikelyPose& pose) { return pose.weight <= 0.0; });
    if (none_counts) {
      return each.table.Fail(
          "weight", "expected more than 0 for at least one likely pose of \"" + each.model + "\"");
    }
  }
}

std::string SetupOf(const std::vector<ModelsPose>& poses, double uniform_share) {
  std::string text;
  for (const auto& [table, model, pose] : poses) {
    const Eigen::Quaterniond& q = pose.q_world_object;
    text += Format("%s likely at (%g, %g, %g, %g) within %g degrees with weight %g, ",
                   model.c_str(),
                   q.w(),
                   q.x(),
                   q.y(),
                   q.z(),
                   pose.spread / kDegree,
                   pose.weight);
  }
  return text.empty() ? text : text + Format("anything else %g, ", uniform_share);
}

void ReadFusion(ConfigReader::Table table, FusionConfig* config) {
  OrientationFilterParameters& orientation = config->tracker.orientation;
  PositionFilterParameters& position = config->tracker.position;
  ViewpointParameters& viewpoint = config->tracker.viewpoint;
  table.Read("k", &config->k, So3Grid::kSmallest, So3Grid::kLargest);
  const auto read_degrees = [&](const char* key, double* angle, double lowest, double highest) {
    double degrees = *angle / kDegree;
    table.Read(key, &degrees, lowest, highest);
    *angle = degrees * kDegree;
  };
  read_degrees("sigma_deg", &orientation.sigma_cw, 0.1, 90.0);
  orientation.mode.sigma = orientation.sigma_cw;
  double sigma_vw_mm2 = orientation.sigma_vw * 1e6;
  table.Read("verification_sigma_mm2", &sigma_vw_mm2, 1e-3, 1e6);
  orientation.sigma_vw = sigma_vw_mm2 * 1e-6;
  table.Read("w_min", &orientation.peaks.w_min, 0.01, 1.0);
  table.Read("w_max", &orientation.peaks.w_max, 0.01, 1.0);
  table.Read("w_mode", &orientation.peaks.w_mode, 0.01, 1.0);
  std::string final_orientation = Name(orientation.final_orientation);
  table.ReadChoice("final_orientation", &final_orientation, FinalOrientationNames());
  orientation.final_orientation = *FinalOrientationFromName(final_orientation);
  table.Read("mode_bandwidth", &orientation.mode.bandwidth, 0.0, 100.0);
  read_degrees("motion_sigma_deg", &orientation.sigma_motion, 0.0, 10.0);
  table.Read("prior_uniform_share", &config->tracker.prior_uniform_share, 0.0, 1.0);
  read_degrees("converge_deg", &orientation.converge_angle, 1e-3, 180.0);
  table.Read("converge_views", &orientation.converge_views, 1, kMostViews);
  table.Read("min_views", &orientation.min_views, 1, kMostViews);
  table.Read("position_gate_m", &position.gate, 1e-4, 10.0);
  table.Read("position_huber_m", &position.huber, 1e-5, 10.0);
  table.Read("gate_m", &config->tracker.gate, 1e-4, 10.0);
  table.Read("gate_fraction", &config->tracker.gate_fraction, 0.0, 10.0);
  table.Read("overlap_fraction", &config->tracker.overlap_fraction, 0.0, 1.0);
  table.Read("confirm_views", &config->tracker.confirm_views, 1, kMostViews);
  table.Read("lost_views", &config->tracker.lost_views, 1, kMostViews);
  read_degrees("viewpoint_rotation_deg", &viewpoint.rotation, 0.01, 180.0);
  table.Read("viewpoint_translation_m", &viewpoint.translation, 1e-4, 10.0);
  table.Read("frames_per_view", &config->views.frames_per_view, 1, 1000);
  table.ReadPath("state_file", &config->state_file);
  config->views.viewpoint = viewpoint;
}

std::string CandidatesText(const ViewCandidateParameters& candidates) {
  std::string text =
      candidates.count > 0
          ? Format("views %d", candidates.count)
          : Format("views %d x %d", candidates.num_elevations, candidates.num_azimuths);
  return text + Format(" from %g to %g degrees at %g m around (%g, %g, %g)",
                       candidates.lowest_elevation / kDegree,
                       candidates.highest_elevation / kDegree,
                       candidates.radius,
                       candidates.target.x(),
                       candidates.target.y(),
                       candidates.target.z());
}

// A table of a model that is not in use is a slip of the pen.
Result<void> CheckTablesModels(const ConfusionConfig& confusion,
                               const std::vector<std::string>& names) {
  for (const auto& [model, file] : confusion.tables) {
    if (std::ranges::find(names, model) != names.end()) continue;
    std::string in_use;
    for (const std::string& name : names) in_use += (in_use.empty() ? "" : ", ") + name;
    return Error{ErrorCode::kNotFound,
                 Format("confusion.tables names \"%s\", expected one of the models in use: %s",
                        model.c_str(),
                        in_use.c_str())};
  }
  return {};
}

// Several keys that don't go together.
Error OfTable(const char* table, const Error& error) {
  return {error.code, Format("[%s] %s", table, error.message.c_str())};
}

}  // namespace

Result<FusionConfig> ReadFusionConfig(ConfigReader& config) {
  FusionConfig result;
  ReadFusion(config.Root().Sub("fusion"), &result);
  std::vector<ModelsPose> likely_poses = ReadLikelyPoses(config.Root().Sub("fusion"));
  PlannerConfig planner = ReadPlannerConfig(config);
  planner.views.viewpoint = result.views.viewpoint;
  planner.views.frames_per_view = result.views.frames_per_view;
  result.views = std::move(planner.views);
  result.criterion = planner.criterion;
  result.criterion_seed = planner.seed;
  const ConfusionConfig confusion = ReadConfusionConfig(config);
  result.refinement = ReadObjectRefinementConfig(config);
  const ModelsConfig models = ReadModelsConfig(config);
  IgnoreTablesOfOthers(config);
  if (Result<void> read = config.Finish(); !read) return read.error();
  if (Result<void> valid = result.tracker.Validate(); !valid) {
    return OfTable("fusion", valid.error());
  }
  if (Result<void> valid = result.views.Validate(); !valid) {
    return OfTable("planner", valid.error());
  }
  if (Result<void> valid = result.refinement.parameters.Validate(); !valid) {
    return OfTable("fusion.refinement", valid.error());
  }
  const Result<std::vector<std::string>> names = FindModels(models);
  if (!names) return names.error();
  if (Result<void> known = CheckTablesModels(confusion, *names); !known) return known.error();
  const ConfusionSetup confusion_setup = ReadConfusionSetup(config, confusion.estimator);
  for (const std::string& name : *names) {
    const Result<ObjectModel> model = LoadObjectModel(models.folder / name);
    if (!model) return model.error();
    TrackedModel& tracked = result.models[name];
    tracked = TrackedModel{model->center, model->diameter, model->symmetry, {}};
    auto table = LoadConfusion(confusion, confusion_setup, *model, models.folder / name);
    if (table) tracked.confusion = std::move(table).value();
    if (!table) result.refused_tables[name] = table.error().message;
    if (!result.refinement.camera.empty()) {
      result.refined_models[name] = std::make_shared<const RefinedModel>(*model);
    }
    result.shapes[name] = {DecimateMesh(model->mesh, kCoarseLevel), RadiusAboutCenter(*model)};
    result.setup += Format("%s %llx symmetry %s, ",
                           name.c_str(),
                           static_cast<unsigned long long>(model->mesh_hash),
                           SymmetryText(model->symmetry).c_str());
  }
  result.setup += SetupOf(likely_poses, result.tracker.prior_uniform_share);
  GiveToModels(std::move(likely_poses), &result.models);
  if (Result<void> read = config.Finish(); !read) return read.error();
  result.setup += CandidatesText(result.views.candidates);
  return result;
}

}  // namespace vantage
