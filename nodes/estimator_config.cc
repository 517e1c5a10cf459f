#include "nodes/estimator_config.h"

#include <algorithm>

#include "common/format.h"
#include "nodes/process.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

void ReadCamera(ConfigReader& config, ConfigReader::Table& own, std::string* camera) {
  ConfigReader::Table cameras = config.Root().Sub("camera");
  const std::vector<std::string> names = cameras.Keys();
  cameras.IgnoreAll();
  if (!own.Has("camera") && names.size() == 1) *camera = names.front();
  own.Read("camera", camera);
  if (camera->empty() && !own.Has("camera")) return own.Require("camera");
  const bool is_name =
      !camera->empty() && camera->size() <= 32 && std::ranges::all_of(*camera, [](unsigned char c) {
        return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
      });
  if (!is_name) {
    own.Fail("camera", "expected 1 to 32 capitals, digits and '_', the <NAME> of CAMERA_<NAME>");
  } else if (!names.empty() && std::ranges::find(names, *camera) == names.end()) {
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    own.Fail("camera",
             "expected the name of a table [camera.<NAME>], of which there are: " + known);
  }
}

void ReadHypotheses(ConfigReader::Table& own, PoseEstimatorParameters* parameters) {
  own.Read("coarse_hypotheses", &parameters->coarse_hypotheses, 1, 100);
  own.Read("fine_hypotheses", &parameters->fine_hypotheses, 1, 100);
  own.Read("hypotheses_per_cluster", &parameters->hypotheses_per_cluster, 1, 3);
  own.Read("normal_radius_m", &parameters->normals.radius, 0.001, 0.1);
}

void ReadSegmentation(ConfigReader::Table table, SegmentationParameters* parameters) {
  std::string support = "auto";
  table.ReadChoice("support_plane", &support, {"auto", "none"});
  parameters->support = support == "auto" ? SegmentationParameters::Support::kAuto
                                          : SegmentationParameters::Support::kNone;
  table.Read("plane_min_extent_m", &parameters->plane.min_extent, 0.0, 100.0);
  table.Read("plane_min_share", &parameters->plane.min_share, 0.0, 1.0);
  table.Read("max_planes", &parameters->plane.max_planes, 1, 10);
  table.Read("min_depth_m", &parameters->min_depth, 0.05, 100.0);
  table.Read("max_depth_m", &parameters->max_depth, 0.05, 100.0);
  table.Read("min_height_m", &parameters->min_height, 0.0, 10.0);
  table.Read("max_height_m", &parameters->max_height, 0.001, 10.0);
  table.Read("hull_margin_m", &parameters->hull_margin, 0.0, 10.0);
  table.Read("largest_gap_m", &parameters->largest_gap, 0.001, 1.0);
  table.Read("min_points", &parameters->min_points, 1, 1000000);
  table.Read("concave_angle_deg", &parameters->concave_angle_deg, 1.0, 180.0);
}

void ReadVerification(ConfigReader::Table table, VerificationParameters* parameters) {
  table.Read("min_score", &parameters->min_score, 0.0, 1.0);
  table.Read("min_visible", &parameters->min_visible, 0.0, 1.0);
  table.Read("inlier_sigmas", &parameters->inlier_sigmas, 0.1, 100.0);
  table.Read("model_error_m", &parameters->model_error, 0.0, 0.1);
  table.Read("edge_px", &parameters->edge_px, 0, 20);
  table.Read("coarse_step_px", &parameters->coarse_step, 1, 32);
  table.Read("missing_cost", &parameters->missing_cost, 0.0, 100.0);
}

void ReadRefinement(ConfigReader::Table table, RefinementParameters* parameters) {
  table.Read("coarse_iterations", &parameters->coarse_iterations, 0, 1000);
  table.Read("fine_iterations", &parameters->fine_iterations, 0, 1000);
  table.Read("final_iterations", &parameters->final_iterations, 0, 1000);
  table.Read("tukey_sigmas", &parameters->tukey_sigmas, 0.1, 100.0);
  table.Read("model_error_m", &parameters->model_error, 0.0, 0.1);
}

Result<PpfModel> LoadPpfModel(const fs::path& folder, const PpfTableParameters& parameters) {
  Result<ObjectModel> object = LoadObjectModel(folder);
  if (!object) return object.error();
  Result<PpfTable> stored = PpfTable::Load(folder / "ppf.bin", object->mesh_hash);
  if (stored && stored->parameters() == parameters) {
    return PpfModel{std::move(object).value(), std::move(stored).value()};
  }
  Result<PpfTable> trained = PpfTable::Train(object->samples, object->diameter, parameters);
  if (!trained) {
    return Error{trained.error().code, folder.string() + ": " + trained.error().message};
  }
  return PpfModel{std::move(object).value(), std::move(trained).value()};
}

}  // namespace

void ReadEstimatorConfig(ConfigReader& config,
                         ConfigReader::Table& own,
                         EstimatorConfig* result,
                         PoseEstimatorParameters* parameters) {
  ReadCamera(config, own, &result->camera);
  int64_t seed = 1;
  own.Read("seed", &seed, int64_t{0}, int64_t{1} << 62U);
  result->seed = static_cast<uint64_t>(seed);
  own.Read("rest_window_s", &result->rest_window_s, 0.0, 5.0);
  ReadHypotheses(own, parameters);
  result->models = ReadModelsConfig(config);
  ConfigReader::Table root = config.Root();
  ReadSegmentation(root.Sub("segmentation"), &parameters->segmentation);
  ReadVerification(root.Sub("verification"), &parameters->verification);
  ReadRefinement(root.Sub("refinement"), &parameters->refinement);
}

Result<std::vector<ObjectModel>> LoadModels(const ModelsConfig& config) {
  const Result<std::vector<std::string>> names = FindModels(config);
  if (!names) return names.error();
  std::vector<ObjectModel> models;
  for (const std::string& name : *names) {
    Result<ObjectModel> model = LoadObjectModel(config.folder / name);
    if (!model) return model.error();
    models.push_back(std::move(model).value());
  }
  return models;
}

Result<std::vector<PpfModel>> LoadPpfModels(const ModelsConfig& config,
                                            const PpfTableParameters& parameters) {
  const Result<std::vector<std::string>> names = FindModels(config);
  if (!names) return names.error();
  std::vector<PpfModel> models;
  for (const std::string& name : *names) {
    Result<PpfModel> model = LoadPpfModel(config.folder / name, parameters);
    if (!model) return model.error();
    models.push_back(std::move(model).value());
  }
  return models;
}

}  // namespace vantage
