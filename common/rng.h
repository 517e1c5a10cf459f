#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace vantage {

/// Pseudo-random numbers that are the same on every platform and standard library.
/// PCG32 of O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms
/// for Random Number Generation", 2014 (the XSH-RR variant).
class Rng {
 public:
  explicit Rng(uint64_t seed, uint64_t stream = 0);

  /// Uniform over all 32-bit values.
  uint32_t NextUint32();
  /// Uniform over {0 ... bound - 1}; `bound` > 0.
  uint32_t Below(uint32_t bound);
  /// Uniform in [0, 1).
  double Uniform();
  /// Uniform in [lo, hi).
  double Uniform(double lo, double hi) { return lo + (hi - lo) * Uniform(); }
  /// Standard normal (Box-Muller).
  double Normal();
  /// Uniform over the unit sphere.
  Eigen::Vector3d UnitVector();
  /// Uniform over SO(3) (Shoemake 1992).
  Eigen::Quaterniond Rotation();

 private:
  uint64_t state_;
  uint64_t increment_;
  double spare_normal_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace vantage
