#include "nodes/ppf_config.h"

#include <algorithm>

#include "common/format.h"
#include "nodes/process.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

void ReadCamera(ConfigReader& config, ConfigReader::Table& ppf, std::string* camera) {
  ConfigReader::Table cameras = config.Root().Sub("camera");
  const std::vector<std::string> names = cameras.Keys();
  cameras.IgnoreAll();
  if (!ppf.Has("camera") && names.size() == 1) *camera = names.front();
  ppf.Read("camera", camera);
  if (camera->empty() && !ppf.Has("camera")) return ppf.Require("camera");
  const bool is_name =
      !camera->empty() && camera->size() <= 32 && std::ranges::all_of(*camera, [](unsigned char c) {
        return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
      });
  if (!is_name) {
    ppf.Fail("camera", "expected 1 to 32 capitals, digits and '_', the <NAME> of CAMERA_<NAME>");
  } else if (!names.empty() && std::ranges::find(names, *camera) == names.end()) {
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    ppf.Fail("camera",
             "expected the name of a table [camera.<NAME>], of which there are: " + known);
  }
}

void ReadMatching(ConfigReader::Table& ppf, PpfEstimatorParameters* parameters) {
  PpfTableParameters& table = parameters->table;
  ppf.Read("sample_distance", &table.sample_distance, 0.01, 0.5);
  ppf.Read("distance_step", &table.distance_step, 0.01, 0.5);
  ppf.Read("angle_step_deg", &table.angle_step_deg, 4.0, 60.0);
  PpfVotingParameters& voting = parameters->voting;
  ppf.Read("reference_share", &voting.reference_share, 0.001, 1.0);
  ppf.Read("min_references", &voting.min_references, 1, 10000);
  ppf.Read("max_references", &voting.max_references, 1, 10000);
  ppf.Read("turn_bins", &voting.turn_bins, 4, 360);
  ppf.Read("spread", &voting.spread, 0.0, 0.5);
  ppf.Read("peaks_per_reference", &voting.peaks_per_reference, 1, 100);
  ppf.Read("max_hypotheses", &voting.max_hypotheses, 1, 1000);
  ppf.Read("coarse_hypotheses", &parameters->coarse_hypotheses, 1, 100);
  ppf.Read("fine_hypotheses", &parameters->fine_hypotheses, 1, 100);
  ppf.Read("hypotheses_per_cluster", &parameters->hypotheses_per_cluster, 1, 3);
  ppf.Read("normal_radius_m", &parameters->normals.radius, 0.001, 0.1);
}

void ReadSegmentation(ConfigReader::Table table, SegmentationParameters* parameters) {
  std::string support = "auto";
  table.ReadChoice("support_plane", &support, {"auto", "none"});
  parameters->support = support == "auto" ? SegmentationParameters::Support::kAuto
                                          : SegmentationParameters::Support::kNone;
  table.Read("plane_min_extent_m", &parameters->plane.min_extent, 0.0, 100.0);
  table.Read("plane_min_share", &parameters->plane.min_share, 0.0, 1.0);
  table.Read("min_depth_m", &parameters->min_depth, 0.05, 100.0);
  table.Read("max_depth_m", &parameters->max_depth, 0.05, 100.0);
  table.Read("min_height_m", &parameters->min_height, 0.0, 10.0);
  table.Read("max_height_m", &parameters->max_height, 0.001, 10.0);
  table.Read("hull_margin_m", &parameters->hull_margin, 0.0, 10.0);
  table.Read("largest_gap_m", &parameters->largest_gap, 0.001, 1.0);
  table.Read("min_points", &parameters->min_points, 1, 1000000);
}

void ReadVerification(ConfigReader::Table table, VerificationParameters* parameters) {
  table.Read("min_score", &parameters->min_score, 0.0, 1.0);
  table.Read("inlier_sigmas", &parameters->inlier_sigmas, 0.1, 100.0);
  table.Read("model_error_m", &parameters->model_error, 0.0, 0.1);
  table.Read("edge_px", &parameters->edge_px, 0, 20);
  table.Read("coarse_step_px", &parameters->coarse_step, 1, 32);
}

void ReadRefinement(ConfigReader::Table table, RefinementParameters* parameters) {
  table.Read("coarse_iterations", &parameters->coarse_iterations, 0, 1000);
  table.Read("fine_iterations", &parameters->fine_iterations, 0, 1000);
  table.Read("final_iterations", &parameters->final_iterations, 0, 1000);
  table.Read("tukey_sigmas", &parameters->tukey_sigmas, 0.1, 100.0);
  table.Read("model_error_m", &parameters->model_error, 0.0, 0.1);
}

Result<PpfEstimator::Model> LoadPpfModel(const fs::path& folder,
                                         const PpfTableParameters& parameters) {
  Result<ObjectModel> object = LoadObjectModel(folder);
  if (!object) return object.error();
  Result<PpfTable> stored = PpfTable::Load(folder / "ppf.bin", object->mesh_hash);
  if (stored && stored->parameters() == parameters) {
    return PpfEstimator::Model{std::move(object).value(), std::move(stored).value()};
  }
  Result<PpfTable> trained = PpfTable::Train(object->samples, object->diameter, parameters);
  if (!trained) {
    return Error{trained.error().code, folder.string() + ": " + trained.error().message};
  }
  return PpfEstimator::Model{std::move(object).value(), std::move(trained).value()};
}

}  // namespace

Result<PpfConfig> ReadPpfConfig(ConfigReader& config) {
  PpfConfig result;
  ConfigReader::Table root = config.Root();
  ConfigReader::Table ppf = root.Sub("ppf");
  ReadCamera(config, ppf, &result.camera);
  int64_t seed = 1;
  ppf.Read("seed", &seed, int64_t{0}, int64_t{1} << 62U);
  result.seed = static_cast<uint64_t>(seed);
  ppf.Read("rest_window_s", &result.rest_window_s, 0.0, 5.0);
  ReadMatching(ppf, &result.estimator);
  result.models = ReadModelsConfig(config);
  ReadSegmentation(root.Sub("segmentation"), &result.estimator.segmentation);
  ReadVerification(root.Sub("verification"), &result.estimator.verification);
  ReadRefinement(root.Sub("refinement"), &result.estimator.refinement);
  IgnoreTablesOfOthers(config);
  if (Result<void> read = config.Finish(); !read) return read.error();
  if (Result<void> valid = result.estimator.Validate(); !valid) return valid.error();
  return result;
}

Result<std::vector<PpfEstimator::Model>> LoadPpfModels(const ModelsConfig& config,
                                                       const PpfTableParameters& parameters) {
  const Result<std::vector<std::string>> names = FindModels(config);
  if (!names) return names.error();
  std::vector<PpfEstimator::Model> models;
  for (const std::string& name : *names) {
    Result<PpfEstimator::Model> model = LoadPpfModel(config.folder / name, parameters);
    if (!model) return model.error();
    models.push_back(std::move(model).value());
  }
  return models;
}

}  // namespace vantage
