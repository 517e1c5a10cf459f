#include "tools/evaluate/tuning.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "common/format.h"
#include "common/statistics.h"

namespace vantage {
namespace {

TuningTrial Judge(const FusionMethod& method,
                  const std::vector<double>& values,
                  std::span<const SequenceOutcome> outcomes,
                  double wrong_mode_deg) {
  std::vector<double> errors;
  std::vector<double> seconds;
  double num_wrong = 0.0;
  for (const SequenceOutcome& outcome : outcomes) {
    const bool has_estimate =
        !outcome.symmetric_deg.empty() && !std::isnan(outcome.symmetric_deg.back());
    errors.push_back(has_estimate ? outcome.symmetric_deg.back() : 180.0);
    seconds.push_back(outcome.seconds_per_view);
    if (errors.back() > wrong_mode_deg) num_wrong += 1.0;
  }
  TuningTrial trial;
  trial.method_id = method.info.id;
  trial.parameters = method.info.parameters;
  trial.values = values;
  trial.median_deg = Median(errors);
  trial.mean_deg = Mean(errors);
  trial.wrong_mode_rate = num_wrong / static_cast<double>(errors.size());
  trial.seconds_per_view = Median(seconds);
  return trial;
}

/// Trials of one method.
class Search {
 public:
  Search(const TunableMethod& method,
         std::span<const EvaluatedSequence> sequences,
         const TuningParameters& parameters,
         const std::stop_token& stop,
         const TuningProgress& progress)
      : method_(method),
        sequences_(sequences),
        parameters_(parameters),
        stop_(stop),
        progress_(progress) {
    expected_ = 1;
    for (const MethodParameter& parameter : method.parameters) {
      expected_ += static_cast<int64_t>(parameter.candidates.size()) - 1;
    }
    expected_ *= static_cast<int64_t>(sequences.size());
  }

  /// Tries those that were not tried yet. False after a stop.
  bool Try(const std::vector<std::vector<double>>& candidates) {
    std::vector<std::vector<double>> untried;
    std::vector<FusionMethod> methods;
    for (const std::vector<double>& values : candidates) {
      if (std::any_of(trials_.begin(), trials_.end(), [&](const TuningTrial& trial) {
            return trial.values == values;
          })) {
        continue;
      }
      untried.push_back(values);
      methods.push_back(method_.With(values));
    }
    if (methods.empty()) return true;
    const auto outcomes =
        RunMethods(methods, sequences_, parameters_.run, stop_, [&](int64_t done) {
          Tell(static_cast<int64_t>(methods.size()) * done);
        });
    if (outcomes.empty()) return false;
    for (size_t i = 0; i < methods.size(); ++i) {
      trials_.push_back(Judge(methods[i], untried[i], outcomes[i], parameters_.wrong_mode_deg));
    }
    return true;
  }
  [[nodiscard]] size_t best() const { return BestTrial(trials_, parameters_.rate_tolerance); }
  [[nodiscard]] std::vector<TuningTrial>& trials() { return trials_; }

 private:
  /// @param done of the trials in work.
  void Tell(int64_t done) const {
    const auto before = static_cast<int64_t>(trials_.size() * sequences_.size());
    if (progress_) progress_(std::min(before + done, expected_), expected_);
  }

  const TunableMethod& method_;
  std::span<const EvaluatedSequence> sequences_;
  const TuningParameters& parameters_;
  const std::stop_token& stop_;
  const TuningProgress& progress_;
  std::vector<TuningTrial> trials_;
  int64_t expected_ = 0;  // Sequences to fuse, if one turn is enough.
};

}  // namespace

size_t BestTrial(std::span<const TuningTrial> trials, double rate_tolerance) {
  VANTAGE_CHECK(!trials.empty(), "trials of a method");
  double least_rate = 1.0;
  for (const TuningTrial& trial : trials) least_rate = std::min(least_rate, trial.wrong_mode_rate);
  size_t best = trials.size();
  for (size_t i = 0; i < trials.size(); ++i) {
    if (trials[i].wrong_mode_rate > least_rate + rate_tolerance) continue;
    if (best == trials.size() || trials[i].median_deg < trials[best].median_deg) best = i;
  }
  return best;
}

std::vector<TuningTrial> TuneMethod(const TunableMethod& method,
                                    std::span<const EvaluatedSequence> sequences,
                                    const TuningParameters& parameters,
                                    const std::stop_token& stop,
                                    const TuningProgress& progress) {
  VANTAGE_CHECK(!sequences.empty(), "sequences to tune on");
  Search search(method, sequences, parameters, stop, progress);
  if (!search.Try({method.Values()})) return {};
  // Every turn but the last finds a better trial among finitely many.
  for (size_t unchanged = 0, turn = 0; unchanged < method.parameters.size(); ++turn) {
    const size_t axis = turn % method.parameters.size();
    const size_t before = search.best();
    std::vector<std::vector<double>> candidates;
    for (const double value : method.parameters[axis].candidates) {
      candidates.push_back(search.trials()[before].values);
      candidates.back()[axis] = value;
    }
    if (!search.Try(candidates)) return {};
    unchanged = search.best() == before ? unchanged + 1 : 0;
  }
  search.trials()[search.best()].is_best = true;
  search.trials().front().is_used = true;
  return std::move(search.trials());
}

std::string TuningCsv(std::span<const TuningTrial> trials) {
  std::string csv =
      "method,parameters,median_deg,mean_deg,wrong_mode_rate,seconds_per_view,is_best,is_used\n";
  for (const TuningTrial& trial : trials) {
    csv += Format("%s,\"%s\",%.6f,%.6f,%.6f,%.3g,%d,%d\n",
                  trial.method_id.c_str(),
                  trial.parameters.c_str(),
                  trial.median_deg,
                  trial.mean_deg,
                  trial.wrong_mode_rate,
                  trial.seconds_per_view,
                  trial.is_best ? 1 : 0,
                  trial.is_used ? 1 : 0);
  }
  return csv;
}

std::string TuningText(std::span<const TuningTrial> trials) {
  std::string text = Format("%-23s %-8s %-8s %-9s %s\n",
                            "method",
                            "median",
                            "mean",
                            "wrong",
                            "parameters (errors in deg, * best, + used)");
  for (const TuningTrial& trial : trials) {
    if (!trial.is_best && !trial.is_used) continue;
    text += Format("%-23s %-8.4f %-8.4f %-7.2f %% %s%s %s\n",
                   trial.method_id.c_str(),
                   trial.median_deg,
                   trial.mean_deg,
                   100.0 * trial.wrong_mode_rate,
                   trial.is_best ? "*" : " ",
                   trial.is_used ? "+" : " ",
                   trial.parameters.c_str());
  }
  return text;
}

}  // namespace vantage
