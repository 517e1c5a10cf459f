#include "common/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "common/check.h"

namespace vantage {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

bool AnyNan(std::span<const double> values) {
  return std::any_of(values.begin(), values.end(), [](double value) { return std::isnan(value); });
}

// Quantile() of at least one value, none NaN. Reorders them.
double QuantileInPlace(std::span<double> values, double q) {
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::ptrdiff_t>(place);
  const auto middle = values.begin() + below;
  std::nth_element(values.begin(), middle, values.end());
  const double low = *middle;
  const double share = place - static_cast<double>(below);
  if (share == 0.0) return low;
  const double high = *std::min_element(middle + 1, values.end());
  return low == high ? low : low + share * (high - low);  // Equal infinities have no difference.
}

double EvaluateInPlace(Statistic statistic, std::span<double> values) {
  return statistic == Statistic::kMedian ? QuantileInPlace(values, 0.5) : Mean(values);
}

// Draws places with replacement, each group as often as it has values.
class Resampler {
 public:
  Resampler(size_t count, std::span<const int> groups) {
    VANTAGE_CHECK(groups.empty() || groups.size() == count, "a group for each value");
    std::map<int, std::vector<uint32_t>> places;
    for (size_t i = 0; i < count; ++i) {
      places[groups.empty() ? 0 : groups[i]].push_back(static_cast<uint32_t>(i));
    }
    for (auto& [group, of_group] : places) strata_.push_back(std::move(of_group));
  }

  // Calls `take(n, place)` for the n-th draw.
  template <class Take>
  void Draw(Rng& rng, const Take& take) const {
    size_t n = 0;
    for (const std::vector<uint32_t>& places : strata_) {
      const auto size = static_cast<uint32_t>(places.size());
      for (uint32_t i = 0; i < size; ++i) take(n++, places[rng.Below(size)]);
    }
  }

 private:
  std::vector<std::vector<uint32_t>> strata_;
};

void Check(const BootstrapParameters& parameters) {
  VANTAGE_CHECK(parameters.resamples > 0, "bootstrap resamples");
  VANTAGE_CHECK(parameters.confidence > 0.0 && parameters.confidence < 1.0,
                "confidence of a bootstrap interval");
}

Interval PercentileInterval(double value, double confidence, std::span<double> resampled) {
  if (AnyNan(resampled)) return {value, kNone, kNone};  // Differences of infinities.
  const double tail = 0.5 * (1.0 - confidence);
  return {value, QuantileInPlace(resampled, tail), QuantileInPlace(resampled, 1.0 - tail)};
}

}  // namespace

double Quantile(std::span<const double> values, double q) {
  if (values.empty() || AnyNan(values)) return kNone;
  std::vector<double> copy(values.begin(), values.end());
  return QuantileInPlace(copy, q);
}

double Median(std::span<const double> values) { return Quantile(values, 0.5); }

double Mean(std::span<const double> values) {
  if (values.empty()) return kNone;
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double Evaluate(Statistic statistic, std::span<const double> values) {
  return statistic == Statistic::kMedian ? Median(values) : Mean(values);
}

Interval BootstrapInterval(std::span<const double> values,
                           Statistic statistic,
                           const BootstrapParameters& parameters,
                           Rng& rng) {
  Check(parameters);
  const Resampler resampler(values.size(), parameters.groups);
  if (values.empty() || AnyNan(values)) return {kNone, kNone, kNone};
  std::vector<double> drawn(values.size());
  std::vector<double> resampled(static_cast<size_t>(parameters.resamples));
  for (double& result : resampled) {
    resampler.Draw(rng, [&](size_t n, uint32_t place) { drawn[n] = values[place]; });
    result = EvaluateInPlace(statistic, drawn);
  }
  return PercentileInterval(Evaluate(statistic, values), parameters.confidence, resampled);
}

Interval PairedDifferenceInterval(std::span<const double> a,
                                  std::span<const double> b,
                                  Statistic statistic,
                                  const BootstrapParameters& parameters,
                                  Rng& rng) {
  VANTAGE_CHECK(a.size() == b.size(), "paired samples of different lengths");
  std::vector<double> differences(a.size());
  for (size_t i = 0; i < a.size(); ++i) differences[i] = a[i] - b[i];
  return BootstrapInterval(differences, statistic, parameters, rng);
}

Interval DifferenceInterval(std::span<const double> a,
                            std::span<const double> b,
                            Statistic statistic,
                            const BootstrapParameters& parameters,
                            Rng& rng) {
  Check(parameters);
  VANTAGE_CHECK(a.size() == b.size(), "paired samples of different lengths");
  const Resampler resampler(a.size(), parameters.groups);
  if (a.empty() || AnyNan(a) || AnyNan(b)) return {kNone, kNone, kNone};
  std::vector<double> drawn_a(a.size());
  std::vector<double> drawn_b(b.size());
  std::vector<double> resampled(static_cast<size_t>(parameters.resamples));
  for (double& result : resampled) {
    resampler.Draw(rng, [&](size_t n, uint32_t place) {
      drawn_a[n] = a[place];
      drawn_b[n] = b[place];
    });
    result = EvaluateInPlace(statistic, drawn_a) - EvaluateInPlace(statistic, drawn_b);
  }
  return PercentileInterval(
      Evaluate(statistic, a) - Evaluate(statistic, b), parameters.confidence, resampled);
}

}  // namespace vantage
