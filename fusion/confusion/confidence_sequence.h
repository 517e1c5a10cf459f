#pragma once

#include "common/statistics.h"

namespace vantage {

/// The shares p that are not refuted at level alpha by `successes` of `trials`: those at which the
/// likelihood ratio of the mixture over all shares (Jeffreys' Beta(1/2, 1/2)) to p stays below
/// 1 / alpha. This ratio is a martingale under p that begins at 1, so that the probability that its
/// true share is *ever* left out is at most alpha (Ville): the interval may be looked at after each
/// trial, and trials stopped by what it says (Robbins, "Statistical methods related to the law of
/// the iterated logarithm", 1970; Howard, Ramdas, McAuliffe and Sekhon, "Time-uniform,
/// nonparametric, nonasymptotic confidence sequences", 2021).
/// @param successes in 0..trials. @param trials >= 0; none leaves all of [0, 1].
/// @param alpha in (0, 1).
Interval ConfidenceSequence(int successes, int trials, double alpha = 0.05);

}  // namespace vantage
