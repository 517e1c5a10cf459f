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

}  // namespace vantage
