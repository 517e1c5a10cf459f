#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/evaluate/dataset_results.h"

namespace vantage {

/// MakeEstimator(), or another one in tests.
using EstimatorMaker = std::function<Result<DatasetEstimator>(
    const std::string&, std::vector<ObjectModel>, SegmentationParameters::Support)>;

/// Called after each image with how many of how many are done.
using DatasetProgress = std::function<void(int64_t done, int64_t total)>;

/// Looks for every object of every view: in its segment where one is known, and in the whole image
/// where that shows more. The same for equal arguments but for times; every image has random
/// numbers of its own.
/// @param results `datasets`, `seed` and `bounds` are read, outcomes appended.
/// @return false after a stop: outcomes are missing. Errors: as `make`.
Result<bool> RunDatasets(const std::vector<std::string>& estimators,
                         const EstimatorMaker& make,
                         const std::stop_token& stop,
                         const DatasetProgress& progress,
                         DatasetResults* results);

}  // namespace vantage
