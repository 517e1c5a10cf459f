#include "fusion/confusion/held_out.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"

namespace vantage {
namespace {

int32_t CountOf(const RowTrials& row, int32_t ordinal) {
  const auto at = std::lower_bound(
      row.detected.begin(),
      row.detected.end(),
      ordinal,
      [](const RowTrials::Count& count, int32_t wanted) { return count.ordinal < wanted; });
  return at != row.detected.end() && at->ordinal == ordinal ? at->count : 0;
}

// Sum of the log probabilities of each trial, given the others of its row.
double LeaveOneOut(std::span<const RowTrials> rows, int num_cells, double a) {
  double sum = 0.0;
  for (const RowTrials& row : rows) {
    if (row.trials == 0) continue;
    const double all = row.trials - 1 + a * (num_cells + 1.0);
    const auto add = [&](int32_t count) {
      if (count > 0) sum += count * std::log((count - 1 + a) / all);
    };
    add(row.missed);
    for (const RowTrials::Count& detected : row.detected) add(detected.count);
  }
  return sum;
}

}  // namespace

double HeldOutLogLikelihood(const RowTrials& row,
                            const RowTrials& held_out,
                            int num_cells,
                            double pseudo_count) {
  VANTAGE_CHECK(num_cells > 0 && pseudo_count > 0.0, "cells and a pseudo-count");
  if (held_out.trials == 0) return 0.0;
  const double all = row.trials + pseudo_count * (num_cells + 1.0);
  double sum = 0.0;
  const auto add = [&](int32_t times, int32_t count) {
    if (times > 0) sum += times * std::log((count + pseudo_count) / all);
  };
  add(held_out.missed, row.missed);
  for (const RowTrials::Count& seen : held_out.detected)
    add(seen.count, CountOf(row, seen.ordinal));
  return sum / held_out.trials;
}

double LeaveOneOutPseudoCount(std::span<const RowTrials> rows, int num_cells) {
  VANTAGE_CHECK(num_cells > 0, "a pseudo-count needs a cell");
  // Golden section over log a; the likelihood has one maximum.
  constexpr double kGolden = 0.6180339887498949;
  double low = std::log(1e-6);
  double high = 0.0;
  const auto value = [&](double log_a) { return LeaveOneOut(rows, num_cells, std::exp(log_a)); };
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double at_left = value(left);
  double at_right = value(right);
  while (high - low > 0.01) {
    if (at_left >= at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - kGolden * (high - low);
      at_left = value(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + kGolden * (high - low);
      at_right = value(right);
    }
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace vantage
