#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "fusion/confusion/contingency_table.h"
#include "perception/model/object_model.h"
#include "tools/evaluate/confusion_results.h"
#include "tools/evaluate/detection_sequence.h"

namespace vantage {

/// An object's circles of views and its table.
struct ReweightedObject {
  const ObjectModel* model = nullptr;
  const ContingencyTable* table = nullptr;
  std::span<const DetectionSequence> circles;
};

/// Table 3 at one k: the final orientation after each circle by voting, VW voting, CW and CW+VW
/// clustering, by accuracy weights (AW; eq. 9, 10) on cells with the paper's pseudo-count, alone
/// and with verification weights, and by the filter that knows the table (each detection a kernel
/// at all truths that it may stand for, peaks by the belief), by clustering and by the density's
/// mode. Clusterings have the widths that they are tuned to. Errors:
/// AccuracyWeights::FromDirections(), ConfusionModel::Make().
Result<ReweightingTable> CompareReweighting(int k, std::span<const ReweightedObject> objects);

/// Fig. 16, 17: the peaks of the histogram of confidence weights, of that of accuracy weights (eq.
/// 10) and of the belief by the table on an object's first circle after so many views, and a
/// picture of each. Errors: AccuracyWeights::FromDirections(), ConfusionModel::Make().
Result<void> AppendPeaks(int k,
                         const ReweightedObject& object,
                         const std::vector<int>& after_views,
                         const std::string& group,
                         ConfusionResults* results);

}  // namespace vantage
