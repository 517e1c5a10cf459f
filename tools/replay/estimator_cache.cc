#include "tools/replay/estimator_cache.h"

#include <utility>
#include <vector>

#include "nodes/ppf_config.h"
#include "nodes/shot_config.h"
#include "perception/estimator/estimator_text.h"

namespace vantage {
namespace {

Result<std::unique_ptr<PoseEstimator>> MakePpf(const PpfConfig& config) {
  Result<std::vector<PpfModel>> models = LoadPpfModels(config.models, config.estimator.table);
  if (!models) return models.error();
  return CreatePpfEstimator(std::move(models).value(), config.estimator);
}

Result<std::unique_ptr<PoseEstimator>> MakeShot(const ShotConfig& config) {
  Result<std::vector<ObjectModel>> models = LoadModels(config.models);
  if (!models) return models.error();
  return CreateShotEstimator(std::move(models).value(), config.estimator);
}

std::string KeyOf(const ModelsConfig& models, const std::string& parameters) {
  std::string key = parameters;
  key += models.folder.string();
  for (const std::string& name : models.use) key += '\n' + name;
  return key;
}

}  // namespace

Result<EstimatorCache::Made> EstimatorCache::Make(const std::string& name, ConfigReader& config) {
  const auto make = [this](const auto& read, const auto& factory) -> Result<Made> {
    if (!read) return read.error();
    Result<std::shared_ptr<const PoseEstimator>> estimator =
        Find(KeyOf(read->models, EstimatorText(read->estimator)), [&] { return factory(*read); });
    if (!estimator) return estimator.error();
    return Made{*read, std::move(estimator).value()};
  };
  if (name == "ppf") return make(ReadPpfConfig(config), MakePpf);
  return make(ReadShotConfig(config), MakeShot);
}

Result<std::shared_ptr<const PoseEstimator>> EstimatorCache::Find(const std::string& key,
                                                                  const Factory& make) {
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<Entry>& place = entries_[key];
    if (!place) place = std::make_shared<Entry>();
    entry = place;
  }
  const std::lock_guard lock(entry->mutex);
  if (!entry->estimator) {
    Result<std::unique_ptr<PoseEstimator>> made = make();
    if (!made) return made.error();
    entry->estimator = std::move(made).value();
  }
  return entry->estimator;
}

}  // namespace vantage
