#include "fusion/confusion/several_tests.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/check.h"

namespace vantage {

SeveralTests Combine(std::span<const double> p_values, double alpha) {
  std::vector<double> sorted(p_values.begin(), p_values.end());
  for (const double p : sorted) VANTAGE_CHECK(p >= 0.0 && p <= 1.0, "a p value in [0, 1]");
  std::sort(sorted.begin(), sorted.end());
  SeveralTests all;
  all.num_tests = static_cast<int>(sorted.size());
  all.expected_rejected = alpha * all.num_tests;
  for (const double p : sorted) all.num_rejected += p <= alpha ? 1 : 0;
  // The least p against alpha / n, the next against alpha / (n - 1), until one is not rejected.
  while (all.num_rejected_by_holm < all.num_tests &&
         sorted[static_cast<size_t>(all.num_rejected_by_holm)] *
                 (all.num_tests - all.num_rejected_by_holm) <=
             alpha) {
    ++all.num_rejected_by_holm;
  }
  if (!sorted.empty()) all.smallest_p = std::min(1.0, all.num_tests * sorted.front());
  all.uniformity_p = UniformityTest(sorted);
  return all;
}

double UniformityTest(std::span<const double> values) {
  if (values.empty()) return 1.0;
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const auto n = static_cast<double>(sorted.size());
  double distance = 0.0;
  for (size_t i = 0; i < sorted.size(); ++i) {
    const auto below = static_cast<double>(i);
    distance = std::max({distance, sorted[i] - below / n, (below + 1.0) / n - sorted[i]});
  }
  const double lambda = (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n)) * distance;
  if (lambda < 0.2) return 1.0;  // To 1e-12; the series converges slowly here.
  double p = 0.0;
  for (int j = 1; j <= 100; ++j) {
    p += (j % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * j * j * lambda * lambda);
  }
  return std::clamp(p, 0.0, 1.0);
}

}  // namespace vantage
