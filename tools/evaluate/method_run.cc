#include "tools/evaluate/method_run.h"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "common/so3.h"
#include "tools/evaluate/method_cache.h"

namespace vantage {
namespace {

double ThreadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

Eigen::Quaterniond Rotation(const Pose& pose) {
  return Eigen::Quaterniond(pose.linear()).normalized();
}

// As RunMethod, by the cache where it is worth it.
SequenceOutcome RunOrRecall(const FusionMethod& method,
                            const EvaluatedSequence& evaluated,
                            uint64_t seed,
                            MethodCache* cache) {
  if (cache == nullptr || !method.is_slow) return RunMethod(method, evaluated, seed);
  if (auto kept = cache->Find(method.info, evaluated, seed)) return *std::move(kept);
  SequenceOutcome outcome = RunMethod(method, evaluated, seed);
  cache->Keep(method.info, evaluated, seed, outcome);
  return outcome;
}

}  // namespace

SequenceOutcome RunMethod(const FusionMethod& method,
                          const EvaluatedSequence& evaluated,
                          uint64_t seed) {
  SequenceOutcome outcome;
  const Eigen::Quaterniond truth = Rotation(evaluated.sequence->T_world_object);
  const std::unique_ptr<OrientationFusion> fusion = method.make(seed, *evaluated.symmetry);
  double seconds = 0.0;
  int num_fused = 0;
  double error = std::numeric_limits<double>::quiet_NaN();
  double symmetric_error = error;
  for (const DetectedView& view : evaluated.sequence->views) {
    if (!view.detections.empty()) {
      const Detection& best = view.detections.front();
      const double start = ThreadSeconds();
      const auto added =
          fusion->Add({Rotation(view.T_world_camera * best.T_camera_object), best.mse});
      const auto estimate = fusion->Estimate();
      seconds += ThreadSeconds() - start;
      ++num_fused;
      if (added && estimate) {
        error = GeodesicAngle(*estimate, truth) / kDegree;
        symmetric_error = SymmetricAngle(*evaluated.symmetry, *estimate, truth) / kDegree;
      }
    }
    outcome.error_deg.push_back(error);
    outcome.symmetric_deg.push_back(symmetric_error);
  }
  outcome.seconds_per_view = num_fused == 0 ? 0.0 : seconds / num_fused;
  return outcome;
}

std::vector<std::vector<SequenceOutcome>> RunMethods(std::span<const FusionMethod> methods,
                                                     std::span<const EvaluatedSequence> sequences,
                                                     const MethodRunOptions& options,
                                                     const std::stop_token& stop,
                                                     const std::function<void(int64_t)>& progress) {
  std::vector<std::vector<SequenceOutcome>> outcomes(
      methods.size(), std::vector<SequenceOutcome>(sequences.size()));
  std::atomic<size_t> next = 0;
  std::mutex mutex;
  int64_t done = 0;
  const auto work = [&] {
    for (size_t i = next++; i < sequences.size() && !stop.stop_requested(); i = next++) {
      for (size_t m = 0; m < methods.size() && !stop.stop_requested(); ++m) {
        outcomes[m][i] = RunOrRecall(methods[m], sequences[i], options.seed + i, options.cache);
      }
      if (stop.stop_requested()) return;
      const std::lock_guard lock(mutex);
      if (progress) progress(++done);
    }
  };
  {
    std::vector<std::jthread> pool;
    for (int i = 1; i < options.threads; ++i) pool.emplace_back(work);
    work();
  }
  if (stop.stop_requested()) outcomes.clear();
  return outcomes;
}

}  // namespace vantage
