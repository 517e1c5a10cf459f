#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/statistics.h"

namespace vantage {

/// A fusion method as the report names it.
struct MethodInfo {
  std::string id;              ///< "cw_vw_clustering"
  std::string label;           ///< "CW+VW clustering"
  std::string parameters;      ///< in words: "sigma 4 deg, w_min 0.7, w_max 0.9"
  bool is_histogram = false;   ///< a variant of ours, no compared method
  bool is_past_paper = false;  ///< not in the paper
};

/// A line of the paper's Table 1.
struct GridStatistics {
  int k = 0;
  int64_t num_cells = 0;
  double mean_deg = 0.0;       ///< d_nn, representatives to their nearest neighbors
  double deviation_deg = 0.0;  ///< its standard deviation
  double megabytes = 0.0;      ///< 1e6 bytes: grid and a histogram with a weight in every cell
  double build_seconds = 0.0;
};

/// Counts over equal bins that begin at 0.
struct BinCounts {
  double bin_width_deg = 0.0;
  std::vector<int64_t> counts;
};

/// Fig. 8: mean error of the final orientation.
struct ClusteringSweep {
  std::vector<double> w_min;
  std::vector<double> w_max;
  /// [w_min][w_max], deg, modulo symmetry; NaN where w_min > w_max.
  std::vector<std::vector<double>> mean_error_deg;
  std::vector<std::vector<double>> wrong_mode_rate;  ///< alike
};

/// Errors of one model on the circle of views (Table 2, Fig. 10, 14, 15), deg. NaN: the view had no
/// detection, or the method has no estimate yet.
struct CircleErrors {
  std::string model_id;
  std::string symmetry;                         ///< in words
  std::vector<double> detection_deg;            ///< by view
  std::vector<double> detection_symmetric_deg;  ///< by view, modulo symmetry
  /// [method][view]: after so many views.
  std::vector<std::vector<double>> step_deg;
  std::vector<std::vector<double>> step_symmetric_deg;
  /// [run][view]: single runs of the particle filter, modulo symmetry (Fig. 10).
  std::vector<std::vector<double>> particle_runs_deg;
};

/// One method over all simulated sequences, errors modulo symmetry, 95 % bootstrap intervals.
struct MethodAccuracy {
  Interval median_deg;
  Interval mean_deg;
  Interval wrong_mode_rate;
  /// Median of the paired difference of the errors, this method's less the best variant of ours.
  Interval median_difference_deg;
  /// Difference of the medians and of the wrong-mode rates over the same resamples, alike.
  Interval difference_of_medians_deg;
  Interval difference_of_wrong_mode_rates;
  /// The same after the first views alone (EvaluationResults::early_views), when the wrong ones are
  /// not outnumbered yet.
  Interval early_wrong_mode_rate;
  Interval difference_of_early_wrong_mode_rates;
  /// Difference of the medians to the best variant that is not told the symmetry, alike.
  Interval difference_to_blind_deg;
  double seconds_per_view = 0.0;     ///< median, one core
  int64_t num_without_estimate = 0;  ///< sequences; they count as wrong mode
};

/// All sequences of one model.
struct SequenceErrors {
  std::string model_id;
  std::string symmetry;
  int64_t num_views = 0;
  int64_t num_found = 0;                       ///< views with a detection
  std::vector<double> detection_deg;           ///< of all found views, modulo symmetry
  std::vector<std::vector<double>> final_deg;  ///< [method][sequence], modulo symmetry; NaN: none
  std::vector<std::vector<double>> early_deg;  ///< alike, after the first views alone
  std::vector<std::vector<double>> step_median_deg;  ///< [method][view], over the sequences
};

/// All that the report shows.
struct EvaluationResults {
  std::string command;  ///< that makes it again
  std::string version;  ///< of the program
  uint64_t seed = 0;
  double wrong_mode_deg = 0.0;  ///< error from which a final orientation is in the wrong mode
  int views_per_sequence = 0;
  int early_views = 0;  ///< of these, for MethodAccuracy::early_wrong_mode_rate
  int histogram_k = 0;
  std::vector<MethodInfo> methods;
  std::string best_ours;   ///< id of the variant that the differences are taken to
  std::string best_blind;  ///< id of the best that is not told the symmetry
  std::vector<GridStatistics> grids;
  BinCounts grid_angles;     ///< Fig. 4, angles of the representatives, at k = 32
  BinCounts grid_distances;  ///< Fig. 4, d_nn at k = 32
  ClusteringSweep sweep;
  std::vector<CircleErrors> circle;
  std::vector<SequenceErrors> sequences;
  std::vector<MethodAccuracy> accuracy;  ///< by method
};

}  // namespace vantage
