#include "tools/support/report_setup.h"

#include <fstream>
#include <set>

#include "common/format.h"
#include "nodes/config_reader.h"
#include "nodes/models_config.h"
#include "nodes/ppf_config.h"
#include "nodes/process.h"
#include "nodes/sim_config.h"

namespace vantage {
namespace {

Result<void> ReadSimulation(const std::filesystem::path& config_file, ReportSetup* setup) {
  Result<ConfigReader> config = ConfigReader::Open(config_file);
  if (!config) return config.error();
  if (!config->Root().Has("sim")) return {};
  const Result<SimConfig> sim = ReadSimConfig(*config);
  if (!sim) return sim.error();
  IgnoreTablesOfOthers(*config);
  if (Result<void> read = config->Finish(); !read) return read;
  for (const SimObject& object : sim->scene.objects) {
    setup->truth.push_back({object.model_id, object.T_world_object});
  }
  setup->table = sim->scene.table;
  return {};
}

}  // namespace

Result<ReportSetup> LoadReportSetup(const std::filesystem::path& config_file) {
  Result<ConfigReader> config = ConfigReader::Open(config_file);
  if (!config) return config.error();
  const Result<PpfConfig> ppf = ReadPpfConfig(*config);
  if (!ppf) return ppf.error();
  ReportSetup setup;
  setup.camera = ppf->camera;
  if (Result<void> read = ReadSimulation(config_file, &setup); !read) return read.error();

  const Result<std::vector<std::string>> names = FindModels(ppf->models);
  if (!names) return names.error();
  std::set<std::string> ids(names->begin(), names->end());
  for (const TruthObject& truth : setup.truth) ids.insert(truth.model_id);
  for (const std::string& id : ids) {
    Result<ObjectModel> model = LoadObjectModel(ppf->models.folder / id);
    if (!model) return model.error();
    setup.models.emplace(id, std::move(model).value());
  }
  return setup;
}

Result<TruthObject> ReadTruthMatrix(const std::filesystem::path& file,
                                    const std::string& model_id) {
  std::ifstream stream(file);
  if (!stream) {
    return Error{ErrorCode::kNotFound,
                 Format("truth %s can't be read, expected 4 x 4 numbers", file.c_str())};
  }
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) {
    if (!(stream >> matrix(i / 4, i % 4)) || !std::isfinite(matrix(i / 4, i % 4))) {
      return Error{ErrorCode::kCorrupt,
                   Format("truth %s has %d numbers, expected 4 x 4", file.c_str(), i)};
    }
  }
  std::string rest;
  if (stream >> rest) {
    return Error{ErrorCode::kCorrupt, Format("truth %s has more than 4 x 4 numbers", file.c_str())};
  }
  if ((matrix.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).norm() > 1e-6) {
    return Error{ErrorCode::kCorrupt,
                 Format("truth %s does not end with the row 0 0 0 1", file.c_str())};
  }
  const Result<Eigen::Matrix3d> rotation = ProjectToRotation(matrix.topLeftCorner<3, 3>());
  if (!rotation) {
    return Error{ErrorCode::kCorrupt,
                 Format("truth %s: %s", file.c_str(), rotation.error().message.c_str())};
  }
  TruthObject truth;
  truth.model_id = model_id;
  truth.T_world_object.linear() = *rotation;
  truth.T_world_object.translation() = matrix.topRightCorner<3, 1>();
  return truth;
}

}  // namespace vantage
