#include "nodes/confusion_config.h"

#include <utility>

#include "common/format.h"
#include "common/parameter_text.h"
#include "drivers/sim/sensor_text.h"
#include "fusion/confusion/contingency_file.h"
#include "nodes/ppf_config.h"
#include "nodes/shot_config.h"
#include "nodes/sim_config.h"
#include "perception/estimator/estimator_text.h"

namespace vantage {
namespace {

constexpr const char* kNone = "none";

std::string HexHash(uint64_t hash) {
  return Format("%016llx", static_cast<unsigned long long>(hash));
}

// Of a copy of the config, whose errors are of no concern here.
template <class Read>
auto OfCopy(const ConfigReader& config, const Read& read) {
  Result<ConfigReader> copy = ConfigReader::Parse(config.text(), "copy.toml");
  return copy ? read(*copy) : decltype(read(*copy)){};
}

}  // namespace

std::string ConfusionFileName(const std::string& estimator) {
  return Format("confusion-%s.bin", estimator.c_str());
}

ConfusionConfig ReadConfusionConfig(ConfigReader& config) {
  ConfusionConfig result;
  ConfigReader::Table table = config.Root().Sub("confusion");
  table.Read("use", &result.use);
  table.ReadChoice("estimator", &result.estimator, {"ppf", "shot"});
  const auto read_degrees = [&](const char* key, double* angle, double lowest, double highest) {
    double degrees = *angle / kDegree;
    table.Read(key, &degrees, lowest, highest);
    *angle = degrees * kDegree;
  };
  read_degrees("mode_radius_deg", &result.model.mode_radius, 1.0, 30.0);
  table.Read("outlier_share", &result.model.outlier_share, 1e-6, 0.5);
  read_degrees("direction_smoothing_deg", &result.model.direction_smoothing, 0.1, 45.0);
  ConfigReader::Table tables = table.Sub("tables");
  for (const std::string& model : tables.Keys()) {
    std::string file;
    tables.Read(model, &file);
    if (file.empty()) tables.Fail(model, "expected a file or \"none\"");
    result.tables[model] = file == kNone ? file : tables.FromFolder(file).string();
  }
  return result;
}

ConfusionSetup ReadConfusionSetup(const ConfigReader& config, const std::string& estimator) {
  ConfusionSetup setup;
  setup.estimator = estimator;
  setup.estimator_parameters = OfCopy(config, [&](ConfigReader& copy) {
    return estimator == "shot" ? EstimatorText(ReadShotParameters(copy))
                               : EstimatorText(ReadPpfParameters(copy));
  });
  setup.sensor = OfCopy(config, [](ConfigReader& copy) {
    if (!copy.Root().Has("sim")) return std::string();
    const Result<SimConfig> sim = ReadSimConfig(copy);
    if (!sim) return std::string();
    ParameterText text;
    AddSensor(sim->sensor, &text);
    return text.text();
  });
  return setup;
}

Result<std::shared_ptr<const ConfusionModel>> LoadConfusion(const ConfusionConfig& config,
                                                            const ConfusionSetup& setup,
                                                            const ObjectModel& model,
                                                            const std::filesystem::path& folder) {
  using Loaded = std::shared_ptr<const ConfusionModel>;
  const auto named = config.tables.find(model.id);
  const bool is_named = named != config.tables.end();
  if (!config.use || (is_named && named->second == kNone)) return Loaded();
  const std::filesystem::path file =
      is_named ? std::filesystem::path(named->second) : folder / ConfusionFileName(setup.estimator);
  if (!is_named && !std::filesystem::exists(file)) return Loaded();
  const Result<ContingencyTable> table = ReadContingencyTable(file);
  if (!table) return table.error();
  ContingencyKey expected;
  expected.model_id = model.id;
  expected.mesh_hash = HexHash(model.mesh_hash);
  expected.estimator = setup.estimator;
  expected.estimator_parameters = setup.estimator_parameters;
  if (Result<void> fits = CheckContingencyKey(table->key, expected, file.string()); !fits) {
    return fits.error();
  }
  if (table->key.sensor.find(setup.sensor) == std::string::npos) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s was measured with another sensor than [sim.sensor] describes: \"%s\", "
                        "expected it to hold \"%s\"",
                        file.c_str(),
                        table->key.sensor.c_str(),
                        setup.sensor.c_str())};
  }
  Result<ConfusionModel> made = ConfusionModel::Make(*table, model.symmetry, config.model);
  if (!made) return Error{made.error().code, file.string() + ": " + made.error().message};
  return Loaded(std::make_shared<const ConfusionModel>(std::move(made).value()));
}

}  // namespace vantage
