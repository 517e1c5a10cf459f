#include "tools/evaluate/clustering_sweep.h"

#include <atomic>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "common/so3.h"
#include "common/statistics.h"
#include "fusion/orientation_filter.h"
#include "fusion/orientation_histogram.h"
#include "fusion/peaks.h"
#include "fusion/verification_weight.h"

namespace vantage {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

OrientationHistogram Fuse(const So3Grid& grid,
                          const OrientationFilterParameters& parameters,
                          const DetectionSequence& sequence) {
  OrientationHistogram histogram(grid);
  for (const DetectedView& view : sequence.views) {
    if (view.detections.empty()) continue;
    const Detection& best = view.detections.front();
    const Pose T_world_object = view.T_world_camera * best.T_camera_object;
    histogram.Add(Eigen::Quaterniond(T_world_object.linear()).normalized(),
                  parameters.sigma_cw,
                  VerificationWeight(best.mse, parameters.sigma_vw));
  }
  return histogram;
}

// Error for every pair of thresholds, deg, [w_min][w_max].
std::vector<std::vector<double>> Errors(const So3Grid& grid,
                                        const OrientationFilterParameters& parameters,
                                        const EvaluatedSequence& evaluated,
                                        const std::vector<double>& thresholds) {
  const OrientationHistogram histogram = Fuse(grid, parameters, *evaluated.sequence);
  const Eigen::Quaterniond truth =
      Eigen::Quaterniond(evaluated.sequence->T_world_object.linear()).normalized();
  std::vector<std::vector<double>> errors(thresholds.size(),
                                          std::vector<double>(thresholds.size(), kNone));
  for (size_t i = 0; i < thresholds.size(); ++i) {
    for (size_t j = i; j < thresholds.size(); ++j) {
      // Modes below w_max are not looked for: C_max alone counts.
      const auto peaks = FindPeaks(
          histogram, {.w_min = thresholds[i], .w_max = thresholds[j], .w_mode = thresholds[j]});
      if (peaks.empty()) continue;
      errors[i][j] = SymmetricAngle(*evaluated.symmetry, peaks.front().q, truth) / kDegree;
    }
  }
  return errors;
}

}  // namespace

ClusteringSweep SweepClustering(const So3Grid& grid,
                                const OrientationFilterParameters& parameters,
                                std::span<const EvaluatedSequence> sequences,
                                double wrong_mode_deg,
                                int threads,
                                const std::stop_token& stop) {
  ClusteringSweep sweep;
  const std::vector<double> thresholds = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95};
  sweep.w_min = thresholds;
  sweep.w_max = thresholds;
  std::vector<std::vector<std::vector<double>>> errors(sequences.size());
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < sequences.size() && !stop.stop_requested(); i = next++) {
      errors[i] = Errors(grid, parameters, sequences[i], thresholds);
    }
  };
  {
    std::vector<std::jthread> pool;
    for (int i = 1; i < threads; ++i) pool.emplace_back(work);
    work();
  }
  const std::vector<double> none(thresholds.size(), kNone);
  sweep.mean_error_deg.assign(thresholds.size(), none);
  sweep.wrong_mode_rate.assign(thresholds.size(), none);
  if (stop.stop_requested()) return sweep;
  for (size_t i = 0; i < thresholds.size(); ++i) {
    for (size_t j = i; j < thresholds.size(); ++j) {
      std::vector<double> of_pair;
      double num_wrong = 0.0;
      for (const auto& of_sequence : errors) {
        // A sequence without estimate is as wrong as can be.
        if (!(of_sequence[i][j] <= wrong_mode_deg)) num_wrong += 1.0;
        if (!std::isnan(of_sequence[i][j])) of_pair.push_back(of_sequence[i][j]);
      }
      sweep.mean_error_deg[i][j] = Mean(of_pair);
      if (!errors.empty()) {
        sweep.wrong_mode_rate[i][j] = num_wrong / static_cast<double>(errors.size());
      }
    }
  }
  return sweep;
}

}  // namespace vantage
