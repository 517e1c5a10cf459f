#include "fusion/confusion/trial_count.h"

#include <boost/math/distributions/beta.hpp>

#include "common/check.h"

namespace vantage {
namespace {

using Beta = boost::math::beta_distribution<double>;

}  // namespace

int NumTrials(int num_cells, double alpha, double largest_share) {
  VANTAGE_CHECK(num_cells > 0, "eq. 11 needs a cell");
  VANTAGE_CHECK(alpha > 0.0 && alpha < 1.0, "alpha in (0, 1)");
  VANTAGE_CHECK(largest_share > 0.0 && largest_share < 1.0, "largest share in (0, 1)");
  // What lies above the largest share falls with n: double n, then halve the interval.
  const auto enough = [&](int n) {
    return cdf(complement(Beta(0.5, n + 0.5), largest_share)) <= alpha / num_cells;
  };
  if (enough(0)) return 0;
  int too_few = 0;
  int most = 1;
  while (!enough(most)) {
    too_few = most;
    VANTAGE_CHECK(most < (1 << 30), "eq. 11 has no solution below 2^30 trials");
    most *= 2;
  }
  while (most - too_few > 1) {
    const int middle = too_few + (most - too_few) / 2;
    (enough(middle) ? most : too_few) = middle;
  }
  return most;
}

Interval JeffreysInterval(int successes, int trials, double alpha) {
  VANTAGE_CHECK(trials > 0 && successes >= 0 && successes <= trials, "successes of trials");
  VANTAGE_CHECK(alpha > 0.0 && alpha < 1.0, "alpha in (0, 1)");
  const Beta posterior(successes + 0.5, trials - successes + 0.5);
  return {static_cast<double>(successes) / trials,
          successes == 0 ? 0.0 : quantile(posterior, 0.5 * alpha),
          successes == trials ? 1.0 : quantile(complement(posterior, 0.5 * alpha))};
}

}  // namespace vantage
