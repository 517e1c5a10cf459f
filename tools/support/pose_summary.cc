#include "tools/support/pose_summary.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "common/statistics.h"

namespace vantage {
namespace {

// The least value that `share` of the values don't exceed; `values` not empty.
double NearestRank(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<size_t>(rank, 1) - 1];
}

PoseSummary Summarize(const std::string& model, const std::vector<const PoseRecord*>& records) {
  PoseSummary summary;
  summary.model = model;
  summary.estimator = records.front()->estimator;
  summary.is_peer = records.front()->is_peer;
  summary.views = records.size();
  std::vector<double> ms;
  std::vector<double> degrees;
  std::vector<double> millimeters;
  std::map<std::string, std::vector<double>> stages;
  size_t successes = 0;
  for (const PoseRecord* record : records) {
    ms.push_back(record->ms);
    for (const auto& [stage, value] : record->stages_ms) stages[stage].push_back(value);
    if (record->is_success) ++successes;
    if (!record->is_within) continue;
    degrees.push_back(record->angle_deg);
    millimeters.push_back(record->distance_mm);
  }
  const auto percent = [&](size_t count) {
    return 100.0 * static_cast<double>(count) / static_cast<double>(records.size());
  };
  constexpr double kTail = 0.99;
  summary.median_ms = Median(ms);
  summary.p99_ms = NearestRank(ms, kTail);
  for (auto& [stage, values] : stages) {
    values.resize(records.size(), 0.0);
    summary.stages_ms[stage] = Median(values);
  }
  summary.within_pct = percent(degrees.size());
  summary.success_pct = percent(successes);
  summary.median_deg = Median(degrees);
  summary.median_mm = Median(millimeters);
  return summary;
}

// The values that `of` has of the records, each once, in their order.
std::vector<std::string> Names(std::span<const PoseRecord> records, std::string PoseRecord::*of) {
  std::vector<std::string> names;
  for (const PoseRecord& record : records) {
    if (std::find(names.begin(), names.end(), record.*of) == names.end()) {
      names.push_back(record.*of);
    }
  }
  return names;
}

template <class Wanted>
std::vector<PoseSummary> SummarizeAll(std::span<const PoseRecord> records, const Wanted& wanted) {
  std::vector<std::string> models = Names(records, &PoseRecord::model);
  models.emplace_back(PoseComparison::kAll);
  std::vector<PoseSummary> summaries;
  for (const std::string& model : models) {
    for (const std::string& estimator : Names(records, &PoseRecord::estimator)) {
      std::vector<const PoseRecord*> chosen;
      for (const PoseRecord& record : records) {
        const bool fits = record.model == model || model == PoseComparison::kAll;
        if (fits && record.estimator == estimator && wanted(record)) chosen.push_back(&record);
      }
      if (!chosen.empty()) summaries.push_back(Summarize(model, chosen));
    }
  }
  return summaries;
}

const PoseSummary* FindSummary(std::span<const PoseSummary> summaries,
                               const std::string& model,
                               const std::string& estimator) {
  for (const PoseSummary& summary : summaries) {
    if (summary.model == model && summary.estimator == estimator) return &summary;
  }
  return nullptr;
}

}  // namespace

PoseComparison::PoseComparison(std::span<const PoseRecord> records)
    : summaries_(SummarizeAll(records, [](const PoseRecord&) { return true; })) {
  std::set<std::pair<std::string, int>> views;
  for (const PoseRecord& record : records) {
    if (record.is_peer) views.emplace(record.model, record.view);
  }
  beside_peers_ = SummarizeAll(records, [&](const PoseRecord& record) {
    return !record.is_peer && views.contains({record.model, record.view});
  });
}

const PoseSummary* PoseComparison::Summary(const std::string& model,
                                           const std::string& estimator) const {
  return FindSummary(summaries_, model, estimator);
}

const PoseSummary* PoseComparison::BesidePeers(const std::string& model,
                                               const std::string& estimator) const {
  return FindSummary(beside_peers_, model, estimator);
}

const PoseSummary* PoseComparison::FastestPeer(const std::string& model) const {
  const PoseSummary* best = nullptr;
  for (const PoseSummary& summary : summaries_) {
    if (summary.model != model || !summary.is_peer) continue;
    if (best == nullptr || summary.median_ms < best->median_ms) best = &summary;
  }
  return best;
}

const PoseSummary* PoseComparison::MostSuccessfulPeer(const std::string& model) const {
  const auto key = [](const PoseSummary& summary) {
    return std::tuple(-summary.success_pct, summary.median_ms);
  };
  const PoseSummary* best = nullptr;
  for (const PoseSummary& summary : summaries_) {
    if (summary.model != model || !summary.is_peer) continue;
    if (best == nullptr || key(summary) < key(*best)) best = &summary;
  }
  return best;
}

Result<PoseComparison::Figure> PoseComparison::Of(const std::string& estimator,
                                                  const std::string& model,
                                                  const std::string& what) const {
  const PoseSummary* summary = Summary(model, estimator);
  if (summary == nullptr) {
    return Error{ErrorCode::kNotFound, "estimator " + estimator + " did not run on model " + model};
  }
  if (what == "median_ms") return Figure{summary->median_ms, "ms", model};
  if (what == "p99_ms") return Figure{summary->p99_ms, "ms", model};
  if (what == "success_pct") return Figure{summary->success_pct, "%", model};
  if (what == "within_pct") return Figure{summary->within_pct, "%", model};
  const PoseSummary* ours = BesidePeers(model, estimator);
  const PoseSummary* fastest = FastestPeer(model);
  const PoseSummary* best = MostSuccessfulPeer(model);
  if (ours == nullptr || fastest == nullptr || best == nullptr) {
    return Error{ErrorCode::kNotFound, "no peer ran beside " + estimator + " on model " + model};
  }
  if (what == "times_faster_than_fastest_peer") {
    return Figure{fastest->median_ms / ours->median_ms, "x", model};
  }
  if (what == "times_faster_than_most_successful_peer") {
    return Figure{best->median_ms / ours->median_ms, "x", model};
  }
  if (what == "success_above_peers_pct") {
    return Figure{ours->success_pct - best->success_pct, "%", model};
  }
  return Error{ErrorCode::kInvalidArgument, "figure " + what + " is not known"};
}

Result<PoseComparison::Figure> PoseComparison::Find(const std::string& name) const {
  const size_t first = name.find('/');
  const size_t last = name.rfind('/');
  if (first == last) {  // Also when there is none.
    return Error{ErrorCode::kInvalidArgument,
                 "figure " + name + ", expected ESTIMATOR/MODEL/FIGURE"};
  }
  const std::string estimator = name.substr(0, first);
  const std::string model = name.substr(first + 1, last - first - 1);
  const std::string what = name.substr(last + 1);
  if (model != kEvery) return Of(estimator, model, what);
  std::optional<Figure> worst;
  for (const PoseSummary& summary : summaries_) {
    if (summary.estimator != estimator || summary.model == kAll) continue;
    const Result<Figure> figure = Of(estimator, summary.model, what);
    if (!figure) return figure.error();
    const bool less_is_better = figure->unit == "ms";
    const bool is_worse =
        !worst || (less_is_better ? figure->value > worst->value : figure->value < worst->value);
    if (is_worse) worst = *figure;
  }
  if (!worst) return Error{ErrorCode::kNotFound, "estimator " + estimator + " did not run"};
  return *worst;
}

}  // namespace vantage
