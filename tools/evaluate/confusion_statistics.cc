#include "tools/evaluate/confusion_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "common/check.h"
#include "common/format.h"
#include "tools/evaluate/confusion_strategies.h"
#include "tools/evaluate/report_numbers.h"

namespace vantage {
namespace {

constexpr double kFewerThanRandom = 0.5;
constexpr double kFewerThanHeuristic = 0.25;
constexpr double kFewestObjects = 10.0;
constexpr std::array<double, 7> kCalibrationEdges = {0.0, 0.5, 0.7, 0.85, 0.95, 0.99, 1.0};

// The numbers of views of one strategy.
struct Sample {
  std::vector<double> held;
  std::vector<double> reached;
  std::vector<double> never;
  std::vector<double> final_right;
  double claims = 0.0;
  double claims_right = 0.0;
};

void Append(const StrategyRuns& runs, double enough, Sample* sample) {
  for (const std::vector<ConfusionStep>& steps : runs) {
    const int held = ViewsToHold(steps, enough);
    sample->held.push_back(held);
    sample->reached.push_back(ViewsToReach(steps, enough));
    sample->never.push_back(held > static_cast<int>(steps.size()) ? 1.0 : 0.0);
    sample->final_right.push_back(!steps.empty() && steps.back().is_best_right ? 1.0 : 0.0);
    for (const ConfusionStep& step : steps) {
      if (step.best_mass < enough) continue;
      sample->claims += 1.0;
      sample->claims_right += step.is_best_right ? 1.0 : 0.0;
    }
  }
}

size_t IndexOf(const ConfusionResults& results, const char* id) {
  const auto& ids = results.strategy_ids;
  const auto found = std::find(ids.begin(), ids.end(), id);
  VANTAGE_CHECK(found != ids.end(), id);
  return static_cast<size_t>(found - ids.begin());
}

std::vector<ViewsNeeded> Summarize(const std::vector<Sample>& samples,
                                   const ConfusionResults& results,
                                   std::span<const int> groups) {
  BootstrapParameters bootstrap;
  bootstrap.groups = groups;
  const Sample& random = samples[IndexOf(results, kRandomId)];
  const Sample& heuristic = samples[IndexOf(results, kHeuristicId)];
  std::vector<ViewsNeeded> all;
  for (size_t s = 0; s < samples.size(); ++s) {
    const Sample& sample = samples[s];
    Rng rng(results.seed, s + 1);
    ViewsNeeded needed;
    needed.mean = BootstrapInterval(sample.held, Statistic::kMean, bootstrap, rng);
    needed.less_random =
        PairedDifferenceInterval(sample.held, random.held, Statistic::kMean, bootstrap, rng);
    needed.less_heuristic =
        PairedDifferenceInterval(sample.held, heuristic.held, Statistic::kMean, bootstrap, rng);
    needed.median = Median(sample.held);
    needed.reached_mean = Mean(sample.reached);
    needed.never_share = Mean(sample.never);
    needed.final_right = Mean(sample.final_right);
    needed.claims = sample.claims;
    needed.claims_right = sample.claims_right;
    all.push_back(needed);
  }
  return all;
}

std::vector<CalibrationBin> Calibrate(const std::vector<std::vector<StrategyRuns>>& runs) {
  std::vector<CalibrationBin> bins;
  for (size_t i = 0; i + 1 < kCalibrationEdges.size(); ++i) {
    bins.push_back({kCalibrationEdges[i], kCalibrationEdges[i + 1], 0, 0.0, 0.0});
  }
  for (const auto& of_object : runs) {
    for (const StrategyRuns& of_strategy : of_object) {
      for (const auto& steps : of_strategy) {
        for (const ConfusionStep& step : steps) {
          size_t bin = 0;
          while (bin + 1 < bins.size() && step.best_mass >= bins[bin].high) ++bin;
          ++bins[bin].count;
          bins[bin].mean_mass += step.best_mass;
          bins[bin].right += step.is_best_right ? 1.0 : 0.0;
        }
      }
    }
  }
  for (CalibrationBin& bin : bins) {
    if (bin.count == 0) continue;
    bin.mean_mass /= static_cast<double>(bin.count);
    bin.right /= static_cast<double>(bin.count);
  }
  return bins;
}

std::vector<double> StillOpen(const std::vector<Sample>& samples, int views) {
  std::vector<double> shares;
  for (const Sample& sample : samples) {
    for (int n = 0; n <= views; ++n) {
      const auto open = std::count_if(
          sample.held.begin(), sample.held.end(), [n](double held) { return held > n; });
      shares.push_back(static_cast<double>(open) / static_cast<double>(sample.held.size()));
    }
  }
  return shares;
}

ConfusionBar FewerViews(const std::string& name, const Interval& ratio, double bar) {
  return {name,
          1.0 - ratio.value,
          1.0 - ratio.high,
          1.0 - ratio.low,
          bar,
          "share",
          1.0 - ratio.value >= bar};
}

}  // namespace

int ViewsToHold(std::span<const ConfusionStep> steps, double enough) {
  size_t held = steps.size() + 1;
  while (held > 1 && steps[held - 2].right_mass >= enough) --held;
  return static_cast<int>(held);
}

int ViewsToReach(std::span<const ConfusionStep> steps, double enough) {
  size_t reached = 0;
  while (reached < steps.size() && steps[reached].right_mass < enough) ++reached;
  return static_cast<int>(reached + 1);
}

Interval RatioOfMeans(std::span<const double> a,
                      std::span<const double> b,
                      const BootstrapParameters& parameters,
                      Rng& rng) {
  VANTAGE_CHECK(a.size() == b.size() && !a.empty(), "paired samples");
  std::vector<std::vector<size_t>> groups;
  for (size_t i = 0; i < a.size(); ++i) {
    const auto group =
        parameters.groups.empty() ? size_t{0} : static_cast<size_t>(parameters.groups[i]);
    if (groups.size() <= group) groups.resize(group + 1);
    groups[group].push_back(i);
  }
  std::vector<double> ratios;
  for (int resample = 0; resample < parameters.resamples; ++resample) {
    double sum_a = 0.0;
    double sum_b = 0.0;
    for (const std::vector<size_t>& group : groups) {
      for (size_t i = 0; i < group.size(); ++i) {
        const size_t drawn = group[rng.Below(static_cast<uint32_t>(group.size()))];
        sum_a += a[drawn];
        sum_b += b[drawn];
      }
    }
    ratios.push_back(sum_a / sum_b);
  }
  const double tail = 0.5 * (1.0 - parameters.confidence);
  return {Mean(a) / Mean(b), Quantile(ratios, tail), Quantile(ratios, 1.0 - tail)};
}

void SummarizeConfusionViews(const std::vector<std::vector<StrategyRuns>>& runs,
                             const std::vector<ObjectViewsNeeded>& objects,
                             ConfusionResults* results) {
  const size_t num_strategies = results->strategies.size();
  std::vector<Sample> all(num_strategies);
  std::vector<int> groups;
  results->objects = objects;
  for (size_t object = 0; object < runs.size(); ++object) {
    std::vector<Sample> samples(num_strategies);
    for (size_t s = 0; s < num_strategies; ++s) {
      Append(runs[object][s], results->enough, &samples[s]);
      Append(runs[object][s], results->enough, &all[s]);
      results->objects[object].held.push_back(samples[s].held);
    }
    groups.insert(groups.end(), runs[object].front().size(), static_cast<int>(object));
    results->objects[object].strategies = Summarize(samples, *results, {});
  }
  results->all_objects = Summarize(all, *results, groups);
  results->still_open = StillOpen(all, results->views);
  results->calibration = Calibrate(runs);

  BootstrapParameters bootstrap;
  bootstrap.groups = groups;
  Rng rng(results->seed, 1000);
  const std::vector<double>& ours = all[IndexOf(*results, kInformationGainId)].held;
  results->ratio_to_random =
      RatioOfMeans(ours, all[IndexOf(*results, kRandomId)].held, bootstrap, rng);
  results->ratio_to_heuristic =
      RatioOfMeans(ours, all[IndexOf(*results, kHeuristicId)].held, bootstrap, rng);
  const auto count = static_cast<double>(runs.size());
  results->bars = {
      {"symmetric objects", count, count, count, kFewestObjects, "", count >= kFewestObjects},
      FewerViews("fewer views than random", results->ratio_to_random, kFewerThanRandom),
      FewerViews(
          "fewer views than the heuristic", results->ratio_to_heuristic, kFewerThanHeuristic)};
}

void AppendStepQuartiles(const std::vector<StrategyRuns>& runs,
                         const std::string& model_id,
                         ConfusionResults* results) {
  for (size_t s = 0; s < runs.size(); ++s) {
    StepQuartiles line;
    line.model_id = model_id;
    line.strategy = results->strategies[s];
    const auto add = [&](double ConfusionStep::*error,
                         int view,
                         std::vector<double>* low,
                         std::vector<double>* median,
                         std::vector<double>* high) {
      std::vector<double> errors;
      for (const auto& steps : runs[s]) {
        const auto index = static_cast<size_t>(view);
        if (index < steps.size()) errors.push_back(steps[index].*error);
      }
      errors = WithMissing(errors);
      low->push_back(Quantile(errors, 0.25));
      median->push_back(Median(errors));
      high->push_back(Quantile(errors, 0.75));
    };
    for (int view = 0; view < results->views; ++view) {
      add(&ConfusionStep::detection_deg,
          view,
          &line.detection_low,
          &line.detection_median,
          &line.detection_high);
      add(&ConfusionStep::final_deg, view, &line.final_low, &line.final_median, &line.final_high);
    }
    results->steps.push_back(std::move(line));
  }
}

std::vector<std::string> MissedBars(const ConfusionResults& results) {
  std::vector<std::string> missed;
  for (const ConfusionBar& bar : results.bars) {
    if (bar.met) continue;
    missed.push_back(Format("%s: %.3g (%.3g..%.3g)%s%s, expected at least %g",
                            bar.name.c_str(),
                            bar.value,
                            bar.low,
                            bar.high,
                            bar.unit.empty() ? "" : " ",
                            bar.unit.c_str(),
                            bar.bar));
  }
  return missed;
}

}  // namespace vantage
