#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/estimator_config.h"
#include "perception/estimator/pose_estimator.h"

namespace vantage {

/// Estimators that were made already, by what they were made of, so that models are loaded and
/// their tables trained once for all threads and reruns of a process. Any thread may call it.
class EstimatorCache {
 public:
  struct Made {
    EstimatorConfig config;
    std::shared_ptr<const PoseEstimator> estimator;  ///< to Clone()
  };

  /// @param name "ppf" or "shot". @param config from its start.
  /// Errors: the config, or the models.
  Result<Made> Make(const std::string& name, ConfigReader& config);

 private:
  using Factory = std::function<Result<std::unique_ptr<PoseEstimator>>()>;
  struct Entry {
    std::mutex mutex;
    std::shared_ptr<const PoseEstimator> estimator;  // Null until one was made.
  };
  Result<std::shared_ptr<const PoseEstimator>> Find(const std::string& key, const Factory& make);

  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Entry>> entries_;
};

}  // namespace vantage
