#include "tools/contingency/trial_setup.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "common/format.h"
#include "nodes/config_reader.h"
#include "nodes/ppf_config.h"
#include "nodes/process.h"
#include "nodes/shot_config.h"
#include "nodes/sim_config.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

Result<ObjectModel> LoadOrGenerate(const std::string& folder_or_name) {
  std::error_code ignored;
  std::vector<std::string> names = GeneratedObjectNames(ObjectSet::kBundled);
  const std::vector<std::string> ambiguous = GeneratedObjectNames(ObjectSet::kAmbiguous);
  names.insert(names.end(), ambiguous.begin(), ambiguous.end());
  if (fs::exists(folder_or_name, ignored) ||
      std::find(names.begin(), names.end(), folder_or_name) == names.end()) {
    return LoadObjectModel(folder_or_name);
  }
  Result<GeneratedObject> object = GenerateObject(folder_or_name);
  if (!object) return object.error();
  return BuildObjectModel(folder_or_name,
                          std::move(object->mesh),
                          object->symmetry,
                          "vantage-model generate " + folder_or_name,
                          {});
}

}  // namespace

Result<ObjectModel> FindTrialModel(const std::string& folder_or_name) {
  Result<ObjectModel> model = LoadOrGenerate(folder_or_name);
  if (!model) return model;
  if (IsSphere(*model)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is a sphere: every rotation is a symmetry of it, so that its "
                        "orientation does not matter and there is no confusion to measure",
                        folder_or_name.c_str())};
  }
  return model;
}

bool IsSphere(const ObjectModel& model) {
  constexpr double kTolerance = 0.01;  // Of the diameter; less than the sensor's noise.
  double nearest = model.diameter;
  double farthest = 0.0;
  for (const SurfacePoint& point : model.samples) {
    const double distance = (point.position.cast<double>() - model.center).norm();
    nearest = std::min(nearest, distance);
    farthest = std::max(farthest, distance);
  }
  return farthest - nearest <= kTolerance * model.diameter;
}

Result<TrialParameters> ReadTrialParameters(const std::string& estimator,
                                            const std::string& config_file) {
  TrialParameters parameters;
  parameters.estimator = estimator;
  if (config_file.empty()) {
    if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
    return parameters;
  }
  Result<ConfigReader> config = ConfigReader::Open(config_file);
  if (!config) return config.error();
  if (estimator == "shot") {
    parameters.shot = ReadShotParameters(*config);
  } else {
    parameters.ppf = ReadPpfParameters(*config);
  }
  Result<void> sound;
  if (config->Root().Has("sim")) {
    const Result<SimConfig> sim = ReadSimConfig(*config);
    if (!sim) {
      sound = sim.error();
    } else {
      parameters.sensor = sim->sensor;
    }
  }
  IgnoreTablesOfOthers(*config);
  // The file's own errors first: they name the line.
  if (Result<void> read = config->Finish(); !read) return read.error();
  if (!sound) return sound.error();
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  return parameters;
}

ContingencyKey MakeKey(const ObjectModel& model,
                       const TrialParameters& parameters,
                       const TrialPlan& plan,
                       int num_directions,
                       int rows_k) {
  ContingencyKey key;
  key.model_id = model.id;
  key.mesh_hash = Format("%016jx", uintmax_t{model.mesh_hash});
  key.estimator = parameters.estimator;
  key.estimator_parameters = EstimatorText(parameters);
  key.sensor = SensorText(parameters);
  key.stopping = plan.stopping.Text();
  key.seed = plan.seed;
  key.num_directions = num_directions;
  key.rows_k = rows_k;
  return key;
}

TrialDetectorFactory SimulatedDetectors(const ObjectModel& model,
                                        const TrialParameters& parameters) {
  return [&model, parameters]() -> Result<TrialDetector> {
    Result<std::unique_ptr<TrialSimulator>> created = TrialSimulator::Create(model, parameters);
    if (!created) return created.error();
    std::shared_ptr<TrialSimulator> simulator = std::move(created).value();
    return TrialDetector([simulator](const Eigen::Quaterniond& q_camera_object, uint64_t seed) {
      return simulator->Detect(q_camera_object, seed);
    });
  };
}

}  // namespace vantage
