#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "common/rng.h"

namespace vantage {

/// Unit quaternions in single precision, an array a coordinate, and their weights.
struct ParticleArrays {
  std::vector<float> x, y, z, w;
  std::vector<float> weight;

  explicit ParticleArrays(size_t size) : x(size), y(size), z(size), w(size), weight(size) {}
  [[nodiscard]] size_t size() const { return weight.size(); }
};

/// Fills with orientations spread evenly over SO(3), all turned by `turn`, of weight 1: the
/// super-Fibonacci spirals of Alexa, CVPR 2022.
void SpreadEvenly(const Eigen::Quaterniond& turn, ParticleArrays* particles);

/// Sums over all weights.
struct WeightSums {
  double sum = 0.0;
  double sum_of_squares = 0.0;
};

/// Multiplies each weight by scale * (exp(-d^2 / (2 sigma^2)) + floor), with d the angle between
/// the particle and q (paper eq. 2), to within 1e-5 of the factor for sigma >= 0.1 deg.
/// Summed in a fixed order.
WeightSums MultiplyByConfidence(
    const Eigen::Quaterniond& q, double sigma, float floor, float scale, ParticleArrays* particles);

/// Draws as many particles as there are in proportion to their weights, systematically (Thrun et
/// al. 2005, table 4.4), and turns each by a small rotation, normal about each axis. Those come
/// from a table made once: a normal number a particle would cost more than everything else.
class SystematicResampler {
 public:
  SystematicResampler(size_t count, Rng& rng);

  /// Replaces `count` particles by those drawn, in the order of the old ones, all of weight 1.
  /// @param weight_sum of the particles' weights.
  /// @param jitter rad, standard deviation of the small rotations about each axis.
  void Resample(double weight_sum, double jitter, Rng& rng, ParticleArrays* particles);

 private:
  static constexpr size_t kTurns = 1 << 14;

  void MakeTurns(double jitter);
  // Sets draws_[j], ascending, to the particle in whose share of the sum lies (j + offset) / count.
  void Draw(const std::vector<float>& weights, double weight_sum, double offset);

  std::vector<uint32_t> draws_;
  ParticleArrays drawn_;
  std::array<std::vector<float>, 3> normals_;
  ParticleArrays turns_;  // Made of normals_ anew at each resampling.
};

}  // namespace vantage
