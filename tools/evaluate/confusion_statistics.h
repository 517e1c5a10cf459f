#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/statistics.h"
#include "tools/evaluate/confusion_results.h"
#include "tools/evaluate/confusion_views.h"

namespace vantage {

/// The first number of views after which the belief has `enough` mass in the right mode and keeps
/// it to the end of the sequence; one more than the sequence has when it never does.
int ViewsToHold(std::span<const ConfusionStep> steps, double enough);
/// The first number of views after which it has it, whatever comes later.
int ViewsToReach(std::span<const ConfusionStep> steps, double enough);

/// Mean of a by mean of b of paired samples, and its 95 % percentile interval over resamples that
/// draw the same places from both, within groups (as BootstrapParameters).
Interval RatioOfMeans(std::span<const double> a,
                      std::span<const double> b,
                      const BootstrapParameters& parameters,
                      Rng& rng);

/// What the runs of the objects say: fills objects, all_objects, ratios, still_open, calibration
/// and bars of `results`, which has strategies, enough and seed.
/// @param objects [object]; their ids and symmetries in words.
void SummarizeConfusionViews(const std::vector<std::vector<StrategyRuns>>& runs,
                             const std::vector<ObjectViewsNeeded>& objects,
                             ConfusionResults* results);

/// Fig. 18 of one object: quartiles by view for each strategy.
void AppendStepQuartiles(const std::vector<StrategyRuns>& runs,
                         const std::string& model_id,
                         ConfusionResults* results);

/// A sentence for every bar that is missed.
std::vector<std::string> MissedBars(const ConfusionResults& results);

}  // namespace vantage
