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
/// clustering, and by accuracy weights (AW; eq. 9, 10) with the paper's pseudo-count, alone and
/// with verification weights. Clusterings have the widths that they are tuned to.
/// Errors: AccuracyWeights::FromDirections().
Result<ReweightingTable> CompareReweighting(int k, std::span<const ReweightedObject> objects);

/// Fig. 16, 17: the peaks of the histogram of confidence weights and of accuracy weights on an
/// object's first circle after so many views, and a picture of each.
/// Errors: AccuracyWeights::FromDirections().
Result<void> AppendPeaks(int k,
                         const ReweightedObject& object,
                         const std::vector<int>& after_views,
                         const std::string& group,
                         ConfusionResults* results);

}  // namespace vantage
