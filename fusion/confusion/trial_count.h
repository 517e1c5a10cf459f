#pragma once

#include "common/statistics.h"

namespace vantage {

/// The number of trials that the paper takes for each orientation at k = 8 (6.2): eq. 11 and
/// something on top.
inline constexpr int kPaperNumTrials = 250;

/// Eq. 11: the fewest trials after which a cell without a detection has, with probability
/// 1 - alpha, a share of at most `largest_share`, the posterior Beta(1/2, n + 1/2) being that of
/// Jeffreys' prior; alpha divided by the cells (Bonferroni). 200, 239 and 279 for the grids of
/// k = 8, 16 and 32.
/// @param num_cells > 0. @param alpha, @param largest_share in (0, 1).
int NumTrials(int num_cells, double alpha = 0.05, double largest_share = 0.05);

/// A share estimated from trials: value = successes / trials, and the equal-tailed interval of the
/// posterior under Jeffreys' prior, down to 0 at no success and up to 1 at no failure (Brown, Cai
/// and DasGupta, "Interval estimation for a binomial proportion", Statistical Science 2001).
/// @param successes in 0..trials. @param trials > 0. @param alpha in (0, 1): all that may lie
/// outside.
Interval JeffreysInterval(int successes, int trials, double alpha = 0.05);

}  // namespace vantage
