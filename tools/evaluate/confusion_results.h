#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "common/statistics.h"
#include "tools/evaluate/evaluation_results.h"
#include "tools/support/png_image.h"

namespace vantage {

/// A difference rotation q' that an object is confused by (paper eq. 12).
struct ConfusedBy {
  double angle_deg = 0.0;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< in the object's frame
  double share = 0.0;                               ///< of the trials, mean over all directions
  double largest_share = 0.0;                       ///< from the direction where it is largest
};

/// The contingency table of one object.
struct TableFacts {
  std::string model_id;
  std::string symmetry;  ///< in words
  std::string source;    ///< "measured", "cache", "model"
  int num_directions = 0;
  int num_rows = 0;  ///< measured by brute force
  int64_t num_trials = 0;
  double missed = 0.0;  ///< share of trials, mean over all directions
  double right = 0.0;   ///< share of the identity's mode alike
  int num_modes = 0;
  std::vector<ConfusedBy> confused_by;  ///< the most frequent, without the identity
};

/// Table 3: final errors after a circle of views, deg, modulo symmetry. NaN: no estimate.
struct ReweightingTable {
  int k = 0;
  std::vector<MethodInfo> methods;
  std::vector<std::string> model_ids;
  /// [object][method][circle]
  std::vector<std::vector<std::vector<double>>> final_deg;
};

/// The histogram of one object by one reweighting after some views (Fig. 16, 17).
struct PeakFacts {
  std::string model_id;
  std::string method;  ///< "CW", "AW" (eq. 10), "table" (belief)
  int views = 0;
  int num_peaks = 0;               ///< at least w_mode of the highest, or of the most probable
  double best_deg = 0.0;           ///< error of the heaviest peak modulo symmetry
  double share_of_best = 0.0;      ///< of the mass, or probability, in all peaks
  double highest = 0.0;            ///< the heaviest cell's share of the mass
  std::vector<double> others_deg;  ///< angles of the other peaks to the heaviest one
};

/// A picture of the report: name of the file without ".png", and what it shows.
struct ConfusionPicture {
  std::string name;
  std::string group;  ///< which exhibit it belongs to: "fig5", "fig6", "fig16", "fig17"
  std::string caption;
  RgbImage image;
};

/// Errors view by view (Fig. 18) of one object and strategy: quartiles over the sequences, deg,
/// modulo symmetry.
struct StepQuartiles {
  std::string model_id;
  std::string strategy;  ///< label
  std::vector<double> detection_low, detection_median, detection_high;
  std::vector<double> final_low, final_median, final_high;
};

/// Views until the right mode holds, of one strategy, over some sequences.
struct ViewsNeeded {
  Interval mean;  ///< views; sequences where it never holds count as one more than they have
  double median = 0.0;
  double reached_mean = 0.0;  ///< alike, until the first time that it has the mass
  double never_share = 0.0;   ///< of the sequences
  double final_right = 0.0;   ///< share where the best hypothesis is right at the end
  Interval less_random;       ///< views, mean of the paired difference to random
  Interval less_heuristic;    ///< alike to the heuristic
  double claims = 0.0;        ///< steps whose best hypothesis has the mass
  double claims_right = 0.0;  ///< of them, those where it is right
};

struct ObjectViewsNeeded {
  std::string model_id;
  std::string symmetry;
  std::vector<ViewsNeeded> strategies;
  std::vector<std::vector<double>> held;  ///< [strategy][sequence], views
};

/// How often the best hypothesis is right when it has so much mass.
struct CalibrationBin {
  double low = 0.0;
  double high = 1.0;
  int64_t count = 0;
  double mean_mass = 0.0;
  double right = 0.0;
};

/// A number that has to be reached.
struct ConfusionBar {
  std::string name;
  double value = 0.0;
  double low = 0.0;  ///< of its interval
  double high = 0.0;
  double bar = 0.0;  ///< at least
  std::string unit;
  bool met = false;
};

/// All that the report shows.
struct ConfusionResults {
  std::string command;  ///< that makes it again
  std::string version;  ///< of the program
  uint64_t seed = 0;
  int circles = 0;
  int sequences = 0;
  int views = 0;
  int candidates = 0;
  double enough = 0.95;  ///< mass at which the right mode holds
  double right_angle_deg = 0.0;
  std::vector<TableFacts> tables;
  std::vector<ReweightingTable> reweighting;
  std::vector<PeakFacts> peaks;
  std::vector<ConfusionPicture> pictures;
  std::vector<StepQuartiles> steps;
  std::vector<std::string> strategies;  ///< labels
  std::vector<std::string> strategy_ids;
  std::vector<ObjectViewsNeeded> objects;
  std::vector<ViewsNeeded> all_objects;  ///< by strategy
  Interval ratio_to_random;              ///< mean of information gain by that of random
  Interval ratio_to_heuristic;           ///< by that of the heuristic
  std::vector<double> still_open;  ///< [strategy * (views + 1) + n]: share not held after n views
  std::vector<CalibrationBin> calibration;
  std::vector<ConfusionBar> bars;
};

}  // namespace vantage
