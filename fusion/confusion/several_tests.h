#pragma once

#include <span>

namespace vantage {

/// What several tests say together.
struct SeveralTests {
  int num_tests = 0;
  int num_rejected = 0;            ///< with p <= alpha
  double expected_rejected = 0.0;  ///< alpha num_tests, when no hypothesis is wrong
  int num_rejected_by_holm = 0;    ///< at level alpha for all together
  double smallest_p = 1.0;         ///< adjusted by Holm: min(1, num_tests times the least p)
  double uniformity_p = 1.0;       ///< UniformityTest; of independent tests alone
};

/// Counts rejections at level alpha and corrects them (Holm, "A simple sequentially rejective
/// multiple test procedure", Scand. J. Statist. 1979; valid for tests that depend on each other).
/// @param p_values each in [0, 1]; checked. None: nothing rejected.
SeveralTests Combine(std::span<const double> p_values, double alpha = 0.05);

/// p value of the Kolmogorov-Smirnov test of values against the uniform distribution over [0, 1];
/// by the series for many values with Stephens' correction for few (Stephens, "EDF statistics for
/// goodness of fit and some comparisons", JASA 1974). 1 for no values.
double UniformityTest(std::span<const double> values);

}  // namespace vantage
