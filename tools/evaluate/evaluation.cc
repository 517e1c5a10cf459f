#include "tools/evaluate/evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "common/format.h"
#include "common/rng.h"
#include "common/so3.h"
#include "common/statistics.h"
#include "perception/model/symmetry_text.h"
#include "tools/evaluate/method_run.h"

namespace vantage {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

using Outcomes = std::vector<std::vector<SequenceOutcome>>;  // [method][sequence]

Eigen::Quaterniond Rotation(const Pose& pose) {
  return Eigen::Quaterniond(pose.linear()).normalized();
}

// Error of a view's best hypothesis, deg, plain and modulo symmetry; NaN where there is none.
std::pair<double, double> DetectionError(const DetectedView& view,
                                         const DetectionSequence& sequence,
                                         const SymmetryGroup& symmetry) {
  if (view.detections.empty()) return {kNone, kNone};
  const Pose T_world_object = view.T_world_camera * view.detections.front().T_camera_object;
  const Eigen::Quaterniond truth = Rotation(sequence.T_world_object);
  const Eigen::Quaterniond q = Rotation(T_world_object);
  return {GeodesicAngle(q, truth) / kDegree, SymmetricAngle(symmetry, q, truth) / kDegree};
}

CircleErrors ErrorsOnCircle(const ObjectModel& model,
                            const DetectionSequence& circle,
                            const Outcomes& outcomes,
                            size_t sequence) {
  CircleErrors errors;
  errors.model_id = model.id;
  errors.symmetry = SymmetryText(model.symmetry);
  for (const DetectedView& view : circle.views) {
    const auto [plain, symmetric] = DetectionError(view, circle, model.symmetry);
    errors.detection_deg.push_back(plain);
    errors.detection_symmetric_deg.push_back(symmetric);
  }
  for (const auto& of_method : outcomes) {
    errors.step_deg.push_back(of_method[sequence].error_deg);
    errors.step_symmetric_deg.push_back(of_method[sequence].symmetric_deg);
  }
  return errors;
}

// The median after every view over the sequences that have an estimate then.
std::vector<double> MedianByStep(std::span<const SequenceOutcome> outcomes) {
  std::vector<double> medians;
  size_t num_views = 0;
  for (const SequenceOutcome& outcome : outcomes) {
    num_views = std::max(num_views, outcome.symmetric_deg.size());
  }
  for (size_t view = 0; view < num_views; ++view) {
    std::vector<double> errors;
    for (const SequenceOutcome& outcome : outcomes) {
      const std::vector<double>& steps = outcome.symmetric_deg;
      if (view < steps.size() && !std::isnan(steps[view])) errors.push_back(steps[view]);
    }
    medians.push_back(Median(errors));
  }
  return medians;
}

SequenceErrors ErrorsOfModel(const ObjectModel& model,
                             std::span<const DetectionSequence> sequences,
                             const Outcomes& outcomes,
                             size_t first,
                             int early_views) {
  SequenceErrors errors;
  errors.model_id = model.id;
  errors.symmetry = SymmetryText(model.symmetry);
  for (const DetectionSequence& sequence : sequences) {
    for (const DetectedView& view : sequence.views) {
      ++errors.num_views;
      if (view.detections.empty()) continue;
      ++errors.num_found;
      errors.detection_deg.push_back(DetectionError(view, sequence, model.symmetry).second);
    }
  }
  for (const auto& of_method : outcomes) {
    const std::span<const SequenceOutcome> of_model(of_method.data() + first, sequences.size());
    std::vector<double> final_deg;
    std::vector<double> early_deg;
    for (const SequenceOutcome& outcome : of_model) {
      const std::vector<double>& steps = outcome.symmetric_deg;
      final_deg.push_back(steps.empty() ? kNone : steps.back());
      const size_t early = std::min(static_cast<size_t>(early_views), steps.size());
      early_deg.push_back(early == 0 ? kNone : steps[early - 1]);
    }
    errors.final_deg.push_back(std::move(final_deg));
    errors.early_deg.push_back(std::move(early_deg));
    errors.step_median_deg.push_back(MedianByStep(of_model));
  }
  return errors;
}

// What the intervals of one method are made of. A sequence without estimate is as wrong as can be.
struct Sample {
  std::vector<double> error_deg;
  std::vector<double> is_wrong_mode;
  std::vector<double> is_wrong_early;
  int64_t num_without_estimate = 0;
};

Sample SampleOf(const std::vector<SequenceErrors>& all, size_t method, double wrong_mode_deg) {
  Sample sample;
  for (const SequenceErrors& model : all) {
    for (const double error : model.final_deg[method]) {
      const bool has_estimate = !std::isnan(error);
      sample.num_without_estimate += has_estimate ? 0 : 1;
      sample.error_deg.push_back(has_estimate ? error : 180.0);
      sample.is_wrong_mode.push_back(sample.error_deg.back() > wrong_mode_deg ? 1.0 : 0.0);
    }
    for (const double error : model.early_deg[method]) {
      sample.is_wrong_early.push_back(error <= wrong_mode_deg ? 0.0 : 1.0);  // 1 for NaN.
    }
  }
  return sample;
}

std::vector<MethodAccuracy> Accuracies(const EvaluationResults& results,
                                       const Outcomes& outcomes,
                                       const EvaluationParameters& parameters) {
  std::vector<int> groups;
  for (size_t model = 0; model < results.sequences.size(); ++model) {
    const size_t count = results.sequences[model].final_deg.front().size();
    groups.insert(groups.end(), count, static_cast<int>(model));
  }
  if (groups.empty()) return {};
  BootstrapParameters bootstrap;
  bootstrap.resamples = parameters.bootstrap_resamples;
  bootstrap.groups = groups;
  std::vector<Sample> samples;
  size_t best = 0;
  size_t blind = 0;
  for (size_t m = 0; m < results.methods.size(); ++m) {
    samples.push_back(SampleOf(results.sequences, m, results.wrong_mode_deg));
    if (results.methods[m].id == results.best_ours) best = m;
    if (results.methods[m].id == results.best_blind) blind = m;
  }
  std::vector<MethodAccuracy> accuracies;
  for (size_t m = 0; m < samples.size(); ++m) {
    Rng rng(parameters.seed, m + 1);
    const Sample& sample = samples[m];
    MethodAccuracy accuracy;
    accuracy.median_deg = BootstrapInterval(sample.error_deg, Statistic::kMedian, bootstrap, rng);
    accuracy.mean_deg = BootstrapInterval(sample.error_deg, Statistic::kMean, bootstrap, rng);
    accuracy.wrong_mode_rate =
        BootstrapInterval(sample.is_wrong_mode, Statistic::kMean, bootstrap, rng);
    accuracy.median_difference_deg = PairedDifferenceInterval(
        sample.error_deg, samples[best].error_deg, Statistic::kMedian, bootstrap, rng);
    accuracy.difference_of_medians_deg = DifferenceInterval(
        sample.error_deg, samples[best].error_deg, Statistic::kMedian, bootstrap, rng);
    accuracy.difference_of_wrong_mode_rates = DifferenceInterval(
        sample.is_wrong_mode, samples[best].is_wrong_mode, Statistic::kMean, bootstrap, rng);
    accuracy.early_wrong_mode_rate =
        BootstrapInterval(sample.is_wrong_early, Statistic::kMean, bootstrap, rng);
    accuracy.difference_of_early_wrong_mode_rates = DifferenceInterval(
        sample.is_wrong_early, samples[best].is_wrong_early, Statistic::kMean, bootstrap, rng);
    accuracy.difference_to_blind_deg = DifferenceInterval(
        sample.error_deg, samples[blind].error_deg, Statistic::kMedian, bootstrap, rng);
    std::vector<double> seconds;
    for (const SequenceOutcome& outcome : outcomes[m]) seconds.push_back(outcome.seconds_per_view);
    accuracy.seconds_per_view = Median(seconds);
    accuracy.num_without_estimate = sample.num_without_estimate;
    accuracies.push_back(accuracy);
  }
  return accuracies;
}

// Single runs of the particle filter, which differ in their random numbers alone: [run][view].
// Fewer after a stop.
std::vector<std::vector<double>> ParticleRuns(std::span<const FusionMethod> methods,
                                              const EvaluatedSequence& circle,
                                              const EvaluationParameters& parameters,
                                              const std::stop_token& stop) {
  std::vector<std::vector<double>> runs;
  const std::vector<EvaluatedSequence> same(static_cast<size_t>(parameters.particle_runs), circle);
  for (const FusionMethod& method : methods) {
    if (method.info.id != kParticleFilterId) continue;
    const MethodRunOptions options{parameters.seed + 1000, parameters.threads, parameters.cache};
    for (const auto& of_method : RunMethods({&method, 1}, same, options, stop, {})) {
      for (const SequenceOutcome& outcome : of_method) runs.push_back(outcome.symmetric_deg);
    }
  }
  return runs;
}

}  // namespace

Result<void> EvaluationParameters::Validate() const {
  if (threads < 1 || threads > 1024) {
    return Error{ErrorCode::kInvalidArgument, Format("threads = %d, expected 1..1024", threads)};
  }
  if (!(wrong_mode_deg > 0.0 && wrong_mode_deg < 180.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("wrong mode from %g deg, expected between 0 and 180", wrong_mode_deg)};
  }
  if (early_views < 1 || early_views > 1000) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("early views = %d, expected 1..1000", early_views)};
  }
  if (particle_runs < 0 || particle_runs > 1000 || bootstrap_resamples < 1) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("particle runs = %d, bootstrap resamples = %d, expected 0..1000 and above 0",
               particle_runs,
               bootstrap_resamples)};
  }
  return {};
}

bool EvaluateMethods(std::span<const ObjectModel> models,
                     const std::vector<ModelDetections>& detections,
                     std::span<const FusionMethod> methods,
                     const EvaluationParameters& parameters,
                     const std::stop_token& stop,
                     const FusionProgress& progress,
                     EvaluationResults* results) {
  std::vector<EvaluatedSequence> circles;
  std::vector<EvaluatedSequence> random;
  for (size_t i = 0; i < models.size(); ++i) {
    for (const auto& circle : detections[i].circles)
      circles.push_back({&circle, &models[i].symmetry});
    for (const auto& sequence : detections[i].random)
      random.push_back({&sequence, &models[i].symmetry});
  }
  const auto total = static_cast<int64_t>(circles.size() + random.size());
  int64_t before = 0;
  const auto report = [&](int64_t done) {
    if (progress) progress(before + done, total);
  };
  const MethodRunOptions options{parameters.seed, parameters.threads, parameters.cache};
  const Outcomes on_circles = RunMethods(methods, circles, options, stop, report);
  before = static_cast<int64_t>(circles.size());
  const Outcomes on_random = RunMethods(methods, random, options, stop, report);
  if (stop.stop_requested()) return false;

  results->seed = parameters.seed;
  results->wrong_mode_deg = parameters.wrong_mode_deg;
  results->early_views = parameters.early_views;
  results->best_ours = kBestOursId;
  results->best_blind = kBestBlindId;
  results->methods.clear();
  for (const FusionMethod& method : methods) results->methods.push_back(method.info);
  results->circle.clear();
  results->sequences.clear();
  size_t circle = 0;
  size_t first = 0;
  for (size_t i = 0; i < models.size(); ++i) {
    for (const DetectionSequence& sequence : detections[i].circles) {
      results->circle.push_back(ErrorsOnCircle(models[i], sequence, on_circles, circle));
      const auto& shown = parameters.figure10_models;
      if (std::find(shown.begin(), shown.end(), models[i].id) != shown.end()) {
        results->circle.back().particle_runs_deg =
            ParticleRuns(methods, circles[circle], parameters, stop);
      }
      ++circle;
    }
    if (detections[i].random.empty()) continue;
    results->sequences.push_back(
        ErrorsOfModel(models[i], detections[i].random, on_random, first, parameters.early_views));
    first += detections[i].random.size();
  }
  if (stop.stop_requested()) return false;
  results->accuracy = Accuracies(*results, on_random, parameters);
  return true;
}

std::vector<std::string> MissedBars(const EvaluationResults& results) {
  std::vector<std::string> missed;
  if (results.accuracy.empty()) return {"no sequences were evaluated"};
  for (size_t m = 0; m < results.methods.size(); ++m) {
    const MethodInfo& method = results.methods[m];
    if (method.is_past_paper || method.id == results.best_ours) continue;
    const MethodAccuracy& accuracy = results.accuracy[m];
    if (!(accuracy.difference_of_medians_deg.low > 0.0)) {
      missed.push_back(
          Format("%s: its median less that of %s has the interval %.4f..%.4f deg, "
                 "expected above 0",
                 method.label.c_str(),
                 results.best_ours.c_str(),
                 accuracy.difference_of_medians_deg.low,
                 accuracy.difference_of_medians_deg.high));
    }
    if (accuracy.difference_of_wrong_mode_rates.value < 0.0) {
      missed.push_back(Format("%s: its wrong-mode rate is %.4f lower than that of %s",
                              method.label.c_str(),
                              -accuracy.difference_of_wrong_mode_rates.value,
                              results.best_ours.c_str()));
    }
    if (accuracy.difference_of_early_wrong_mode_rates.high < 0.0) {
      missed.push_back(
          Format("%s: its wrong-mode rate after %d views is %.4f lower than that of %s",
                 method.label.c_str(),
                 results.early_views,
                 -accuracy.difference_of_early_wrong_mode_rates.value,
                 results.best_ours.c_str()));
    }
  }
  return missed;
}

}  // namespace vantage
