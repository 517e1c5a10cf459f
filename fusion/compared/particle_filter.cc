#include "fusion/compared/particle_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

// Where the confidence weight is cut off (paper 5.1), in sigma.
constexpr double kCutoff = 3.0;

// Z: the mean of w_c (eq. 2) over SO(3), whose angles have density (1 - cos d) / pi. Simpson's
// rule.
double MeanConfidence(double sigma) {
  constexpr int kIntervals = 2000;
  const double reach = std::min(std::numbers::pi, 10.0 * sigma);
  const double step = reach / kIntervals;
  double sum = 0.0;
  for (int i = 0; i <= kIntervals; ++i) {
    const double angle = i * step;
    const double factor = i == 0 || i == kIntervals ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    const double half_sine = std::sin(0.5 * angle);
    const double w_c = std::exp(-angle * angle / (2.0 * sigma * sigma));
    sum += factor * w_c * 2.0 * half_sine * half_sine;
  }
  return sum * step / (3.0 * std::numbers::pi);
}

}  // namespace

Result<void> ParticleFilterParameters::Validate() const {
  constexpr int kMost = 100000000;
  if (num_particles < 1 || num_particles > kMost) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("num_particles = %d, expected 1 to %d", num_particles, kMost)};
  }
  if (!(sigma_cw >= 0.1 * kDegree && sigma_cw <= 45.0 * kDegree)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma_cw = %g rad, expected 0.1 to 45 degrees", sigma_cw)};
  }
  if (!(outlier_share > 0.0 && outlier_share < 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("outlier_share = %g, expected above 0 and below 1", outlier_share)};
  }
  if (!(jitter >= 0.0 && jitter <= 10.0 * kDegree)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("jitter = %g rad, expected 0 to 10 degrees", jitter)};
  }
  return {};
}

ParticleFilter::ParticleFilter(const ParticleFilterParameters& parameters)
    : parameters_(parameters),
      floor_(static_cast<float>(parameters.outlier_share / (1.0 - parameters.outlier_share) *
                                MeanConfidence(parameters.sigma_cw))),
      rng_(parameters.seed),
      particles_(static_cast<size_t>(std::max(parameters.num_particles, 1))),
      resampler_(particles_.size(), rng_),
      weight_sum_(static_cast<double>(particles_.size())),
      effective_sample_size_(weight_sum_) {
  VANTAGE_CHECK(parameters.Validate().ok(), "parameters of the particle filter");
  SpreadEvenly(rng_.Rotation(), &particles_);
}

Eigen::Quaterniond ParticleFilter::particle(size_t i) const {
  return Eigen::Quaternionf(particles_.w[i], particles_.x[i], particles_.y[i], particles_.z[i])
      .cast<double>()
      .normalized();
}

double ParticleFilter::weight(size_t i) const {
  return static_cast<double>(particles_.weight[i]) / weight_sum_;
}

Result<void> ParticleFilter::Add(const OrientationView& view) {
  if (const Result<void> valid = view.Validate(); !valid) return valid.error();
  // Weights come back to a mean of about 1, whatever their number of factors.
  const auto scale = static_cast<float>(static_cast<double>(particles_.size()) / weight_sum_);
  const WeightSums sums = MultiplyByConfidence(
      view.q_world_object.normalized(), parameters_.sigma_cw, floor_, scale, &particles_);
  weight_sum_ = sums.sum;
  effective_sample_size_ = sums.sum * sums.sum / sums.sum_of_squares;
  has_view_ = true;
  const auto count = static_cast<double>(particles_.size());
  if (effective_sample_size_ < 0.5 * count) {
    const double jitter =
        parameters_.jitter * std::pow(2.0 * effective_sample_size_ / count, -1.0 / 7.0);
    resampler_.Resample(weight_sum_, jitter, rng_, &particles_);
    weight_sum_ = count;
    effective_sample_size_ = count;
  }
  return {};
}

Result<Eigen::Quaterniond> ParticleFilter::Estimate() const {
  if (!has_view_) {
    return Error{ErrorCode::kNotFound, "the densest place of no view yet, expected one or more"};
  }
  return DensestMean();
}

Eigen::Quaterniond ParticleFilter::DensestMean() const {
  // Every n-th particle tells as much: after Add() at least half of all count, and resampling left
  // them in order, so that a part of them is spread like the whole.
  constexpr size_t kEnough = 8192;
  const size_t stride = std::max<size_t>(1, particles_.size() / kEnough);
  std::vector<std::pair<So3Grid::Cell, float>> cells;
  for (size_t i = 0; i < particles_.size(); i += stride) {
    cells.emplace_back(coarse_.CellOf(particle(i)), particles_.weight[i]);
  }
  std::stable_sort(
      cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  So3Grid::Cell heaviest = cells.front().first;
  double most = -1.0;
  for (size_t begin = 0, end = 0; begin < cells.size(); begin = end) {
    double sum = 0.0;
    for (; end < cells.size() && cells[end].first == cells[begin].first; ++end) {
      sum += static_cast<double>(cells[end].second);
    }
    if (sum > most) heaviest = cells[begin].first;
    most = std::max(most, sum);
  }

  // Mean shift from the coarse cell's size down to where the truncated Gaussian ends.
  Eigen::Vector4d mean = coarse_.Representative(heaviest).coeffs();
  double radius = 15.0 * kDegree;
  const double last_radius = kCutoff * parameters_.sigma_cw;
  constexpr int kSteps = 20;
  for (int step = 0; step < kSteps; ++step) {
    const double min_dot = std::cos(0.5 * std::min(radius, std::numbers::pi));
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (size_t i = 0; i < particles_.size(); i += stride) {
      const Eigen::Vector4d q(particles_.x[i], particles_.y[i], particles_.z[i], particles_.w[i]);
      const double dot = q.dot(mean);
      if (std::abs(dot) < min_dot) continue;
      sum += std::copysign(static_cast<double>(particles_.weight[i]), dot) * q;
    }
    if (sum.isZero(0.0)) break;  // None so near: few particles, or a narrow sigma.
    const double moved = (sum.normalized() - mean).norm();
    mean = sum.normalized();
    if (radius == last_radius && moved < 1e-6) break;
    radius = radius > last_radius ? std::max(0.7 * radius, last_radius) : last_radius;
  }
  return Canonical(Eigen::Quaterniond(mean));
}

}  // namespace vantage
