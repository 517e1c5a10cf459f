#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/compared/particle_arrays.h"
#include "fusion/orientation_fusion.h"
#include "fusion/so3_grid.h"

namespace vantage {

struct ParticleFilterParameters {
  int num_particles = 548496;       ///< as many as the grid with k = 32 has cells (paper 7.2)
  double sigma_cw = 4.0 * kDegree;  ///< rad, of the confidence weight (eq. 2), 0.1 deg..pi / 4
  double outlier_share = 0.1;       ///< of the detections, uniform on SO(3); in (0, 1)
  /// rad, standard deviation about each axis after resampling from half as many effective particles
  /// as there are, 0..10 deg; of fewer n it grows as n^(-1/7), the width of the optimal kernel in
  /// three dimensions (Musso, Oudjane and Le Gland, "Improving Regularised Particle Filters",
  /// 2001).
  double jitter = 0.5 * kDegree;
  uint64_t seed = 1;

  [[nodiscard]] Result<void> Validate() const;
};

/// The particle filter that paper 7.2 compares with: sequential importance resampling (Thrun et al.
/// 2005, chapter 4.3) over orientations. A detection multiplies the weight of each particle by the
/// density of the measurement, (1 - outlier_share) w_c / Z + outlier_share, with w_c of eq. 2 and Z
/// its mean over SO(3). Below an effective sample size of half the particles they are drawn anew,
/// systematically, and jittered. q_f is the mean about the densest place.
/// Of single precision and, given the seed, the same on every run. Two sets of 20 bytes a particle
/// are kept, 24 MB for 548,496 of them; views are not.
class ParticleFilter final : public OrientationFusion {
 public:
  /// @param parameters valid; checked.
  explicit ParticleFilter(const ParticleFilterParameters& parameters = {});

  Result<void> Add(const OrientationView& view) override;
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;

  [[nodiscard]] size_t num_particles() const { return particles_.size(); }
  [[nodiscard]] Eigen::Quaterniond particle(size_t i) const;
  /// Weights sum to 1 to within single precision.
  [[nodiscard]] double weight(size_t i) const;
  /// 1 / (sum of squared weights), after the last view and resampling.
  [[nodiscard]] double effective_sample_size() const { return effective_sample_size_; }

 private:
  [[nodiscard]] Eigen::Quaterniond DensestMean() const;

  ParticleFilterParameters parameters_;
  float floor_;  // Of the density of the measurement, relative to its peak.
  Rng rng_;
  So3Grid coarse_{8};  // For the densest place.
  ParticleArrays particles_;
  SystematicResampler resampler_;
  double weight_sum_;  // Weights are kept unscaled.
  double effective_sample_size_;
  bool has_view_ = false;
};

}  // namespace vantage
