#include "fusion/bingham/bingham_smc_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

constexpr double kSphereArea = 2.0 * std::numbers::pi * std::numbers::pi;  // of S^3

/// The sum of term_of(i) over 0 ... count - 1: in float within short blocks, which the compiler
/// makes fast, and in double over these.
template <class Function>
double SumOver(size_t count, const Function& term_of) {
  constexpr size_t kBlock = 256;
  constexpr size_t kLanes = 8;
  std::array<float, kBlock> terms;
  double total = 0.0;
  for (size_t begin = 0; begin < count; begin += kBlock) {
    const size_t size = std::min(kBlock, count - begin);
    for (size_t i = 0; i < size; ++i) terms[i] = term_of(begin + i);
    std::fill(terms.begin() + static_cast<std::ptrdiff_t>(size), terms.end(), 0.0F);
    std::array<float, kLanes> lanes{};
    for (size_t i = 0; i < kBlock; i += kLanes) {
      for (size_t lane = 0; lane < kLanes; ++lane) lanes[lane] += terms[i + lane];
    }
    for (const float lane : lanes) total += static_cast<double>(lane);
  }
  return total;
}

float CosineOfHalf(double angle) {
  return static_cast<float>(std::cos(0.5 * std::min(angle, std::numbers::pi)));
}

/// A small rotation with nearly normal angles about each axis, of standard deviation 1 times
/// `deviation`: sums of four uniform numbers.
Eigen::Vector3f SmallRotation(float deviation, Rng& rng) {
  constexpr float kUnit = 1.0F / 147.8F;  // The deviation of the sum of four bytes.
  Eigen::Vector3f rotation;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const uint32_t bits = rng.NextUint32();
    const uint32_t sum =
        (bits & 255U) + ((bits >> 8U) & 255U) + ((bits >> 16U) & 255U) + (bits >> 24U);
    rotation[k] = (static_cast<float>(sum) - 510.0F) * kUnit * deviation;
  }
  return rotation;
}

/// The unit quaternion x, y, z, w of q (1, rotation / 2).
Eigen::Vector4f Rotated(const Eigen::Vector4f& q, const Eigen::Vector3f& rotation) {
  const float a = 0.5F * rotation[0];
  const float b = 0.5F * rotation[1];
  const float c = 0.5F * rotation[2];
  const Eigen::Vector4f turned(q[0] + q[3] * a + q[1] * c - q[2] * b,
                               q[1] + q[3] * b + q[2] * a - q[0] * c,
                               q[2] + q[3] * c + q[0] * b - q[1] * a,
                               q[3] - q[0] * a - q[1] * b - q[2] * c);
  return turned / std::sqrt(turned.squaredNorm());
}

}  // namespace

Result<void> BinghamSmcParameters::Validate() const {
  constexpr double kSmallestSigma = 0.2 * kDegree;  // Samples are floats.
  if (!(sigma >= kSmallestSigma && sigma <= std::numbers::pi)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("sigma = %g rad, expected at least %g and at most pi", sigma, kSmallestSigma)};
  }
  if (!(peaked_weight > 0.0 && peaked_weight < 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("peaked_weight = %g, expected between 0 and 1", peaked_weight)};
  }
  if (num_samples < 100 || num_samples > 10'000'000) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("num_samples = %d, expected 100 to 10000000", num_samples)};
  }
  if (!(jitter >= 0.0 && jitter <= 10.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("jitter = %g, expected at least 0 and at most 10", jitter)};
  }
  return {};
}

void BinghamSmcFilter::Samples::Resize(size_t count) {
  for (std::vector<float>* coordinate : {&x, &y, &z, &w}) coordinate->resize(count);
}

void BinghamSmcFilter::Samples::Set(size_t i, const Eigen::Vector4f& q) {
  x[i] = q[0];
  y[i] = q[1];
  z[i] = q[2];
  w[i] = q[3];
}

BinghamSmcFilter::BinghamSmcFilter(const BinghamSmcParameters& parameters, uint64_t seed)
    : parameters_(parameters), rng_(seed) {
  const Result<void> valid = parameters.Validate();
  VANTAGE_CHECK(valid.ok(), valid.error().message);
}

Result<void> BinghamSmcFilter::Add(const OrientationView& view) {
  if (const Result<void> valid = view.Validate(); !valid) return valid.error();
  const Eigen::Quaterniond detection = view.q_world_object.normalized();
  const BinghamDistribution peak = BinghamDistribution::Isotropic(detection, parameters_.sigma);
  // All likelihoods are in units of the outlier density, (1 - peaked_weight) / kSphereArea.
  const double odds = parameters_.peaked_weight / (1.0 - parameters_.peaked_weight);
  const double ratio = odds * kSphereArea * std::exp(-peak.log_normalizer());
  const double old_mass =
      samples_.size() == 0 ? 0.0 : (1.0 - uniform_mass_) * Weigh(detection, ratio, peak.z()[0]);
  const double new_mass = uniform_mass_ * odds;
  uniform_mass_ /= old_mass + new_mass + uniform_mass_;
  ++num_views_;

  const double new_share = new_mass / (old_mass + new_mass);
  const double num_samples = parameters_.num_samples;
  // What would be less than one sample is left out.
  if (new_share * num_samples >= 1.0 || EffectiveSampleSize() < 0.5 * num_samples) {
    Resample(peak, new_share);
  }
  return {};
}

double BinghamSmcFilter::Weigh(const Eigen::Quaterniond& detection, double ratio, double z) {
  const Eigen::Vector4f d = detection.coeffs().cast<float>();
  const auto scale = static_cast<float>(ratio);
  const auto concentration = static_cast<float>(z);
  double before = 0.0;
  double after = 0.0;
  float largest = 0.0F;
  for (size_t i = 0; i < weights_.size(); ++i) {
    // The vector part of detection* sample has the length sin(angle / 2), without loss of digits.
    const Eigen::Vector4f q = samples_[i];
    const float a = d[3] * q[0] - d[0] * q[3] - d[1] * q[2] + d[2] * q[1];
    const float b = d[3] * q[1] - d[1] * q[3] - d[2] * q[0] + d[0] * q[2];
    const float c = d[3] * q[2] - d[2] * q[3] - d[0] * q[1] + d[1] * q[0];
    const float exponent = concentration * (a * a + b * b + c * c);
    before += static_cast<double>(weights_[i]);
    constexpr float kNegligible = -60.0F;
    if (exponent > kNegligible) weights_[i] *= 1.0F + scale * std::exp(exponent);
    after += static_cast<double>(weights_[i]);
    largest = std::max(largest, weights_[i]);
  }
  constexpr float kSmallest = 1e-30F;  // Less only costs time, as denormal numbers do.
  for (float& weight : weights_) {
    weight /= largest;
    if (weight < kSmallest) weight = 0.0F;
  }
  return after / before;
}

double BinghamSmcFilter::EffectiveSampleSize() const {
  double sum = 0.0;
  double squared_sum = 0.0;
  for (const float value : weights_) {
    const auto weight = static_cast<double>(value);
    sum += weight;
    squared_sum += weight * weight;
  }
  return sum * sum / squared_sum;
}

void BinghamSmcFilter::Resample(const BinghamDistribution& newborn, double new_share) {
  const auto count = static_cast<size_t>(parameters_.num_samples);
  const auto num_new =
      std::min(count, static_cast<size_t>(new_share * parameters_.num_samples + rng_.Uniform()));
  const size_t num_old = samples_.size() == 0 ? 0 : count - num_new;
  next_samples_.Resize(count);

  double sum = 0.0;
  for (const float weight : weights_) sum += static_cast<double>(weight);
  const double step = sum / std::max(1.0, static_cast<double>(num_old));
  double target = step * rng_.Uniform();
  double cumulated = 0.0;
  const auto deviation =
      static_cast<float>(parameters_.jitter * parameters_.sigma / std::sqrt(num_views_));
  size_t filled = 0;
  for (size_t i = 0; i < samples_.size() && filled < num_old; ++i) {
    cumulated += static_cast<double>(weights_[i]);
    // The last sample takes what rounding leaves over.
    const bool is_last = i + 1 == samples_.size();
    for (; filled < num_old && (target < cumulated || is_last); ++filled, target += step) {
      next_samples_.Set(filled, Rotated(samples_[i], SmallRotation(deviation, rng_)));
    }
  }
  const auto num_drawn = static_cast<int>(count - num_old);
  for (const Eigen::Quaterniond& q : newborn.Sample(num_drawn, rng_)) {
    next_samples_.Set(filled++, q.coeffs().cast<float>());
  }
  std::swap(samples_, next_samples_);
  weights_.assign(count, 1.0F);
}

double BinghamSmcFilter::WeightWithin(const Eigen::Vector4f& center, double angle) const {
  const float limit = CosineOfHalf(angle);
  const float* const x = samples_.x.data();
  const float* const y = samples_.y.data();
  const float* const z = samples_.z.data();
  const float* const w = samples_.w.data();
  const float* const weights = weights_.data();
  return SumOver(samples_.size(), [=](size_t i) {
    const float dot = center[0] * x[i] + center[1] * y[i] + center[2] * z[i] + center[3] * w[i];
    const float weight = weights[i];
    return std::abs(dot) >= limit ? weight : 0.0F;
  });
}

Eigen::Vector4f BinghamSmcFilter::MeanWithin(const Eigen::Vector4f& center, double angle) const {
  const float limit = CosineOfHalf(angle);
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (size_t i = 0; i < samples_.size(); ++i) {
    const Eigen::Vector4f q = samples_[i];
    const float dot = center.dot(q);
    if (std::abs(dot) < limit) continue;
    sum += static_cast<double>(dot < 0.0F ? -weights_[i] : weights_[i]) * q.cast<double>();
  }
  return sum.normalized().cast<float>();
}

Result<Eigen::Quaterniond> BinghamSmcFilter::Estimate() const {
  if (samples_.size() == 0) {
    return Error{ErrorCode::kNotFound, "no view was added yet, expected at least one"};
  }
  // Candidates at equal steps of the cumulated weight: heavy places have many.
  constexpr int kCandidates = 32;
  double sum = 0.0;
  for (const float weight : weights_) sum += static_cast<double>(weight);
  double target = 0.5 / kCandidates * sum;
  double cumulated = 0.0;
  double most = -1.0;
  Eigen::Vector4f best = samples_[0];
  for (size_t i = 0; i < samples_.size(); ++i) {
    cumulated += static_cast<double>(weights_[i]);
    if (cumulated < target) continue;
    while (target <= cumulated) target += sum / kCandidates;
    const double weight = WeightWithin(samples_[i], parameters_.sigma);
    if (weight > most) {
      most = weight;
      best = samples_[i];
    }
  }
  constexpr int kMeanShifts = 5;
  for (int i = 0; i < kMeanShifts; ++i) best = MeanWithin(best, 2.0 * parameters_.sigma);
  return Canonical(Eigen::Quaterniond(Eigen::Vector4d(best.cast<double>())).normalized());
}

}  // namespace vantage
