#include "tools/evaluate/dataset_results.h"

#include <algorithm>
#include <limits>

#include "common/format.h"
#include "common/statistics.h"

namespace vantage {
namespace {

bool IsOf(const DatasetOutcome& outcome, const DatasetSummary& summary) {
  return outcome.dataset == summary.dataset && outcome.estimator == summary.estimator &&
         outcome.search == summary.search;
}

double Largest(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return *std::max_element(values.begin(), values.end());
}

void Fill(const std::vector<DatasetOutcome>& outcomes, DatasetSummary* summary) {
  std::vector<double> angles;
  std::vector<double> distances;
  std::vector<double> seconds;
  const DatasetOutcome* last = nullptr;
  for (const DatasetOutcome& outcome : outcomes) {
    if (!IsOf(outcome, *summary)) continue;
    ++summary->num_objects;
    // Objects of one view follow each other. Every segment is an image of its own.
    const bool is_new_image =
        last == nullptr || last->view != outcome.view || outcome.search == DatasetSearch::kSegment;
    last = &outcome;
    if (is_new_image) {
      summary->num_wrong += outcome.num_wrong;
      seconds.push_back(outcome.seconds);
    }
    if (!outcome.is_found) continue;
    ++summary->num_found;
    summary->num_within += outcome.success.is_within ? 1 : 0;
    summary->num_indistinguishable += outcome.success.is_indistinguishable ? 1 : 0;
    summary->num_succeeded += outcome.success.succeeded() ? 1 : 0;
    angles.push_back(outcome.success.angle);
    distances.push_back(outcome.success.distance);
  }
  summary->median_angle = Median(angles);
  summary->largest_angle = Largest(angles);
  summary->median_distance = Median(distances);
  summary->median_seconds = Median(seconds);
  summary->largest_seconds = Largest(seconds);
}

}  // namespace

std::string Name(DatasetSearch search) {
  return search == DatasetSearch::kWholeImage ? "whole image" : "segment";
}

std::vector<DatasetSummary> Summarize(const DatasetResults& results) {
  std::vector<DatasetSummary> summaries;
  for (const DatasetOutcome& outcome : results.outcomes) {
    const bool is_known =
        std::any_of(summaries.begin(), summaries.end(), [&outcome](const DatasetSummary& summary) {
          return IsOf(outcome, summary);
        });
    if (is_known) continue;
    DatasetSummary summary;
    summary.dataset = outcome.dataset;
    summary.estimator = outcome.estimator;
    summary.search = outcome.search;
    Fill(results.outcomes, &summary);
    summaries.push_back(summary);
  }
  return summaries;
}

std::vector<std::string> MissedBars(const DatasetResults& results) {
  std::vector<std::string> missed;
  for (const DatasetSummary& summary : Summarize(results)) {
    const Dataset& dataset = results.datasets[summary.dataset];
    if (!dataset.bars) continue;
    const DatasetBars& bars = *dataset.bars;
    const std::string who = dataset.name + ", " + summary.estimator;
    if (summary.num_found < bars.min_found) {
      missed.push_back(Format("%s: %d of %d objects found, expected at least %d",
                              who.c_str(),
                              summary.num_found,
                              summary.num_objects,
                              bars.min_found));
    }
    if (!(summary.median_angle <= bars.max_median_angle)) {
      missed.push_back(Format("%s: median rotation error %.2f deg, expected at most %.2f deg",
                              who.c_str(),
                              summary.median_angle / kDegree,
                              bars.max_median_angle / kDegree));
    }
  }
  return missed;
}

}  // namespace vantage
