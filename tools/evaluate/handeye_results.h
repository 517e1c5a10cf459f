#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/statistics.h"

namespace vantage {

/// A method on the trials of one cell: setup, number of views, share of outliers.
struct HandEyeCell {
  std::string method;  ///< label; the first one is ours
  std::string setup;   ///< "eye in hand", "eye to hand"
  int views = 0;
  double outlier_share = 0.0;
  int trials = 0;
  int failed = 0;       ///< trials without a result, left out of the errors
  Interval median_mm;   ///< of the translation's error
  Interval median_deg;  ///< of the rotation's
  Interval rmse_mm;     ///< root of the mean square
  Interval rmse_deg;
  Interval ratio_translation;  ///< of the RMSE to the Cramer-Rao bound's
  Interval ratio_rotation;
  double median_ms = 0.0;  ///< a solve, time of one core
  double least_ms = 0.0;
};

/// What ours says of itself in one cell.
struct HandEyeSelfTest {
  std::string setup;
  int views = 0;
  double outlier_share = 0.0;
  int trials = 0;
  Interval coverage;         ///< share of trials where the 95 % ellipsoid holds the truth
  Interval false_alarms;     ///< share of trials held insufficient, or refused
  double wrong_views = 0.0;  ///< share of views that are wrongly taken or left out
};

/// Motions that don't fix X.
struct HandEyeDegenerate {
  std::string motion;
  std::string setup;
  double outlier_share = 0.0;
  int trials = 0;
  int flagged = 0;     ///< insufficient, or refused
  std::string reason;  ///< of the first trial
};

/// A number that has to be reached.
struct HandEyeBar {
  std::string name;
  double value = 0.0;
  double low = 0.0;  ///< bounds; one may be infinite
  double high = 0.0;
  std::string unit;
  bool met = false;
};

/// All that the report shows.
struct HandEyeResults {
  std::string command;
  std::string version;
  uint64_t seed = 0;
  int trials = 0;                    ///< of ours in each cell
  int peer_trials = 0;               ///< of the others, the first ones of these
  std::vector<std::string> methods;  ///< labels, ours first
  std::vector<HandEyeCell> cells;
  std::vector<HandEyeSelfTest> self_tests;
  std::vector<HandEyeDegenerate> degenerate;
  std::vector<HandEyeBar> bars;
};

/// A sentence for every bar that is missed.
std::vector<std::string> MissedBars(const HandEyeResults& results);

}  // namespace vantage
