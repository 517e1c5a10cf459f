#include "common/rng.h"

#include <cmath>
#include <numbers>

#include "common/check.h"

namespace vantage {

Rng::Rng(uint64_t seed, uint64_t stream) : state_(0), increment_((stream << 1U) | 1U) {
  NextUint32();
  state_ += seed;
  NextUint32();
}

uint32_t Rng::NextUint32() {
  const uint64_t old = state_;
  state_ = old * 6364136223846793005ULL + increment_;
  const auto xorshifted = static_cast<uint32_t>(((old >> 18U) ^ old) >> 27U);
  const auto rotation = static_cast<uint32_t>(old >> 59U);
  return (xorshifted >> rotation) | (xorshifted << ((32U - rotation) & 31U));
}

uint32_t Rng::Below(uint32_t bound) {
  VANTAGE_CHECK(bound > 0, "Rng::Below needs a bound above 0");
  const uint32_t threshold = (0U - bound) % bound;  // Rejects the incomplete last interval.
  while (true) {
    const uint32_t value = NextUint32();
    if (value >= threshold) return value % bound;
  }
}

double Rng::Uniform() {
  const uint64_t high = NextUint32() >> 5U;
  const uint64_t low = NextUint32() >> 6U;
  return static_cast<double>((high << 26U) | low) * 0x1.0p-53;
}

double Rng::Normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_normal_;
  }
  const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
  const double angle = 2.0 * std::numbers::pi * Uniform();
  spare_normal_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

Eigen::Vector3d Rng::UnitVector() {
  const double z = Uniform(-1.0, 1.0);
  const double angle = 2.0 * std::numbers::pi * Uniform();
  const double r = std::sqrt(std::fmax(0.0, 1.0 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Eigen::Quaterniond Rng::Rotation() {
  const double u = Uniform();
  const double a = 2.0 * std::numbers::pi * Uniform();
  const double b = 2.0 * std::numbers::pi * Uniform();
  const double s = std::sqrt(1.0 - u);
  const double c = std::sqrt(u);
  return {c * std::cos(b), s * std::sin(a), s * std::cos(a), c * std::sin(b)};
}

}  // namespace vantage
