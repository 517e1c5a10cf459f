#include "tools/viewer/viewer_setup.h"

#include <memory>
#include <utility>

#include "nodes/config_reader.h"
#include "nodes/models_config.h"
#include "nodes/process.h"
#include "tools/support/log_config.h"

namespace vantage {
namespace {

Result<void> LoadModels(const ModelsConfig& config, ModelMap* models) {
  const Result<std::vector<std::string>> names = FindModels(config);
  if (!names) return names.error();
  for (const std::string& name : *names) {
    Result<ObjectModel> model = LoadObjectModel(config.folder / name);
    if (!model) return model.error();
    models->emplace(name, std::make_shared<const ObjectModel>(std::move(model).value()));
  }
  return {};
}

}  // namespace

Result<ViewerSetup> LoadViewerSetup(const std::string& config_file, const std::string& log) {
  ViewerSetup setup;
  Result<ConfigReader> config = OpenConfig(config_file, log);
  if (!config) {
    if (!config_file.empty()) return config.error();
    setup.warning = config.error().message + "; objects are shown as boxes";
    return setup;
  }
  setup.bus = ReadBusOptions(*config);
  const ModelsConfig models = ReadModelsConfig(*config);
  config->Root().Sub("planner").Read("table_height_m", &setup.table_height, -10.0, 10.0);
  config->Root().Sub("planner").IgnoreAll();
  IgnoreTablesOfOthers(*config);
  if (Result<void> read = config->Finish(); !read) return read.error();
  if (Result<void> loaded = LoadModels(models, &setup.models); !loaded) {
    setup.warning = loaded.error().message + "; objects of it are shown as boxes";
  }
  return setup;
}

}  // namespace vantage
