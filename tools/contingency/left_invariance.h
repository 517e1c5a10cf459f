#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/statistics.h"
#include "common/symmetry_group.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/confusion/several_tests.h"
#include "tools/contingency/measure_table.h"

namespace vantage {

/// How the assumption behind tables by viewing direction is tested.
struct LeftInvarianceParameters {
  static constexpr int kRowsK = 8;  ///< the paper's, of its rows

  int directions = 20;  ///< drawn at random
  int rolls = 3;        ///< evenly about the optical axis
  int rows = 20;        ///< drawn at random
  int trials = 150;     ///< of each sample
  double alpha = 0.05;  ///< level of all tests together
};

/// Trials at one roll of the camera against trials at random rolls, from one cell of directions.
struct RollTest {
  int32_t direction = 0;
  double roll_deg = 0.0;  ///< deg
  double statistic = 0.0;
  double p_value = 1.0;
};

struct LeftInvarianceReport {
  LeftInvarianceParameters parameters;
  std::vector<RollTest> tests;  ///< ascending by direction, then roll
  int permutations = 0;         ///< of each test: so many that Holm's correction can reject
  SeveralTests all;
  double uniformity_p = 1.0;  ///< of the first roll's p values, which are independent
  /// Mean log probability, nat, of held-out trials of the rows: by rows measured themselves, by the
  /// table's directions, and the latter less the former with its 95 % interval.
  int num_rows = 0;
  double rows_log_likelihood = 0.0;
  double directions_log_likelihood = 0.0;
  Interval difference;
  int paper_trials = 0;        ///< eq. 11 for rows of kRowsK
  Interval unseen;             ///< share of an outcome never seen in so many trials (Jeffreys)
  Interval unseen_in_samples;  ///< the same for `trials`
};

/// Measures the samples and tests them. The samples at random rolls are the table's own first
/// trials, or what would have followed them. Depends on the arguments alone, not on threads.
/// @return nothing after a stop. Errors: the table has no trials by direction, parameters; as the
/// factory.
Result<std::optional<LeftInvarianceReport>> TestLeftInvariance(
    const ContingencyTable& table,
    const SymmetryGroup& symmetry,
    const LeftInvarianceParameters& parameters,
    int threads,
    const TrialDetectorFactory& make_detector,
    const std::stop_token& stop,
    const std::function<void(int64_t, int64_t)>& progress);

/// For people, and the same as JSON.
std::string ReportText(const LeftInvarianceReport& report);
std::string ReportJson(const LeftInvarianceReport& report);

}  // namespace vantage
