#include "fusion/confusion/confidence_sequence.h"

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numbers>

#include "common/check.h"

namespace vantage {
namespace {

// Log of s successes and f failures' likelihood at share p; 0 log 0 = 0.
double LogLikelihood(int s, int f, double p) {
  return (s == 0 ? 0.0 : s * std::log(p)) + (f == 0 ? 0.0 : f * std::log1p(-p));
}

// Where the likelihood, falling from `inside` towards `outside`, comes to `least`.
double Crossing(int s, int f, double inside, double outside, double least) {
  if (LogLikelihood(s, f, outside) >= least) return outside;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (inside + outside);
    (LogLikelihood(s, f, middle) >= least ? inside : outside) = middle;
  }
  return outside;  // The side that is sure to hold all that is not refuted.
}

}  // namespace

Interval ConfidenceSequence(int successes, int trials, double alpha) {
  VANTAGE_CHECK(trials >= 0 && successes >= 0 && successes <= trials, "successes of trials");
  VANTAGE_CHECK(alpha > 0.0 && alpha < 1.0, "alpha in (0, 1)");
  if (trials == 0) return {0.5, 0.0, 1.0};
  const int s = successes;
  const int f = trials - successes;
  // Of the mixture: B(s + 1/2, f + 1/2) / B(1/2, 1/2). Not by std::lgamma, which several threads
  // may not call.
  using boost::math::lgamma;
  const double log_mixture =
      lgamma(s + 0.5) + lgamma(f + 0.5) - lgamma(trials + 1.0) - std::log(std::numbers::pi);
  const double least = log_mixture + std::log(alpha);
  const double share = static_cast<double>(s) / trials;
  return {share, Crossing(s, f, share, 0.0, least), Crossing(s, f, share, 1.0, least)};
}

}  // namespace vantage
