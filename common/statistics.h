#pragma once

#include <span>

#include "common/rng.h"

namespace vantage {

/// An estimate and its confidence interval.
struct Interval {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// The q-quantile, 0 <= q <= 1, interpolated linearly between the two values around it (Hyndman and
/// Fan 1996, type 7). NaN for no values or where one is NaN.
double Quantile(std::span<const double> values, double q);
double Median(std::span<const double> values);
double Mean(std::span<const double> values);

/// What an interval is of. A rate is the mean of zeros and ones.
enum class Statistic { kMean, kMedian };

/// Mean() or Median().
double Evaluate(Statistic statistic, std::span<const double> values);

/// How the bootstrap draws (Efron and Tibshirani, "An Introduction to the Bootstrap", 1993).
struct BootstrapParameters {
  int resamples = 2000;      ///< > 0
  double confidence = 0.95;  ///< of the percentile interval (ibid., chapter 13), in (0, 1)
  /// The group of each value, e.g. its object: values are drawn within their group, each of which
  /// keeps its size (stratified). Empty: all values are one group.
  std::span<const int> groups{};
};

/// The statistic of `values` and its percentile interval over resamples. All NaN for no values or
/// where one is NaN. Equal values give an interval of no width: of a rate of 0 or 1 the
/// bootstrap knows no more than that.
Interval BootstrapInterval(std::span<const double> values,
                           Statistic statistic,
                           const BootstrapParameters& parameters,
                           Rng& rng);

/// The statistic of the differences a[i] - b[i] of two equally long samples.
Interval PairedDifferenceInterval(std::span<const double> a,
                                  std::span<const double> b,
                                  Statistic statistic,
                                  const BootstrapParameters& parameters,
                                  Rng& rng);

/// The statistic of a less that of b, where each resample draws the same places from both.
Interval DifferenceInterval(std::span<const double> a,
                            std::span<const double> b,
                            Statistic statistic,
                            const BootstrapParameters& parameters,
                            Rng& rng);

}  // namespace vantage
