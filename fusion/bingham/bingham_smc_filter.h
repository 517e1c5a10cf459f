#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/result.h"
#include "common/rng.h"
#include "common/so3.h"
#include "fusion/bingham/bingham_distribution.h"
#include "fusion/orientation_fusion.h"

namespace vantage {

/// Parameters of BinghamSmcFilter.
struct BinghamSmcParameters {
  double sigma = 4.0 * kDegree;  ///< rad, of a detection about each axis; sigma_cw of the histogram
  double peaked_weight = 0.90;   ///< of the measurement that is no outlier (paper 7.2)
  int num_samples = 100'000;     ///< paper 7.2
  /// Of the diffusion at a resampling after n views: jitter * sigma / sqrt(n) about each axis, as n
  /// agreeing views leave a spread of sigma / sqrt(n). For 100,000 samples of a normal density in
  /// three dimensions regularized particle filters would have 0.2 (Musso, Oudjane and Le Gland
  /// 2001); twice that costs no accuracy and helps where detections err by more than sigma.
  double jitter = 0.4;

  Result<void> Validate() const;
};

/// BMM SMC of Riedel, Marton and Kriegel 2016 (paper 7.2): sequential Monte Carlo with a Bingham
/// mixture as measurement, peaked_weight Bingham(detection, sigma) + (1 - peaked_weight) uniform,
/// and systematic resampling when the effective sample size is below half the number of samples.
///
/// Uniform samples are too sparse for a peaked measurement: of 100,000, about two are within 4
/// degrees of an orientation. So that part of the posterior which is still the uniform prior is a
/// number here, its mass, and what a detection makes of it is sampled exactly. For the first view
/// that are all samples. As in every such filter an orientation is lost once its weight is less
/// than a sample's: several agreeing wrong views at the start may be final.
class BinghamSmcFilter : public OrientationFusion {
 public:
  /// @param parameters valid.
  BinghamSmcFilter(const BinghamSmcParameters& parameters, uint64_t seed);

  Result<void> Add(const OrientationView& view) override;
  /// The mean of the samples around the densest place: of candidates among the samples the one with
  /// the most weight within sigma, then the mean within 2 sigma, repeated from there (mean shift).
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;

 private:
  /// Samples as arrays of their coordinates.
  struct Samples {
    std::vector<float> x, y, z, w;
    [[nodiscard]] size_t size() const { return x.size(); }
    [[nodiscard]] Eigen::Vector4f operator[](size_t i) const { return {x[i], y[i], z[i], w[i]}; }
    void Resize(size_t count);
    void Set(size_t i, const Eigen::Vector4f& q);
  };
  /// Multiplies the weights by 1 + ratio exp(z sin^2(angle / 2)); returns the weights' mean factor.
  double Weigh(const Eigen::Quaterniond& detection, double ratio, double z);
  [[nodiscard]] double EffectiveSampleSize() const;
  /// Replaces the samples: `new_share` of them from `newborn`, the others from the old ones.
  void Resample(const BinghamDistribution& newborn, double new_share);
  [[nodiscard]] double WeightWithin(const Eigen::Vector4f& center, double angle) const;
  [[nodiscard]] Eigen::Vector4f MeanWithin(const Eigen::Vector4f& center, double angle) const;

  BinghamSmcParameters parameters_;
  Rng rng_;
  Samples samples_;
  Samples next_samples_;
  std::vector<float> weights_;  // The largest one is 1.
  double uniform_mass_ = 1.0;   // Of the whole posterior; the samples have the rest.
  int num_views_ = 0;
};

}  // namespace vantage
