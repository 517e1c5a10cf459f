#include "nodes/models_config.h"

#include <algorithm>
#include <set>
#include <system_error>

#include "common/format.h"
#include "perception/model/object_model.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// Names of the model folders in a folder, in order.
Result<std::vector<std::string>> ModelsIn(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    if (fs::is_regular_file(entry->path() / "model.toml", ignored)) {
      names.push_back(entry->path().filename().string());
    }
  }
  if (error) {
    return Error{ErrorCode::kNotFound,
                 Format("[models] folder %s can't be read (%s); expected a folder that holds one "
                        "folder a model: vantage-model generate --output %s",
                        folder.c_str(),
                        error.message().c_str(),
                        folder.c_str())};
  }
  std::ranges::sort(names);
  return names;
}

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

ModelsConfig ReadModelsConfig(ConfigReader& config) {
  ModelsConfig models;
  ConfigReader::Table table = config.Root().Sub("models");
  table.Require("folder");
  table.ReadPath("folder", &models.folder);
  table.Read("use", &models.use);
  if (table.Has("use") && models.use.empty()) {
    table.Fail("use", "expected at least one model, or no such key for all in the folder");
  }
  std::set<std::string> names;
  for (const std::string& name : models.use) {
    if (const Result<void> fits = CheckModelId(name); !fits) {
      table.Fail("use", fits.error().message);
    } else if (!names.insert(name).second) {
      table.Fail("use", Format("\"%s\" is there twice, expected every model once", name.c_str()));
    }
  }
  return models;
}

Result<std::vector<std::string>> FindModels(const ModelsConfig& models) {
  const fs::path& folder = models.folder;
  Result<std::vector<std::string>> there = ModelsIn(folder);
  if (!there) return there.error();
  if (there->empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("[models] folder %s holds no model; make some with: vantage-model generate "
                        "--output %s",
                        folder.c_str(),
                        folder.c_str())};
  }
  for (const std::string& name : models.use) {
    if (std::ranges::find(*there, name) != there->end()) continue;
    return Error{ErrorCode::kNotFound,
                 Format("[models] use names \"%s\", which is not in %s; there are: %s; others come "
                        "from: vantage-model generate, or vantage-model build",
                        name.c_str(),
                        folder.c_str(),
                        Joined(*there).c_str())};
  }
  return models.use.empty() ? std::move(there).value() : models.use;
}

}  // namespace vantage
