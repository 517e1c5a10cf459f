#include "fusion/compared/particle_arrays.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "common/check.h"

namespace vantage {
namespace {

// Particles handled at a time: small enough for the nearest cache.
constexpr size_t kBlock = 256;
constexpr size_t kLanes = 16;

// 2^x for -1e9 < x <= 0, to 2e-7 of it; 0 below 2^-126.
inline float Exp2(float x) {
  const auto whole = static_cast<int32_t>(x - 0.5F);  // Rounds to nearest.
  const float rest = x - static_cast<float>(whole);
  float power = 0.00134004322F;  // Chebyshev fit of 2^rest on [-1/2, 1/2].
  power = power * rest + 0.0096760371F;
  power = power * rest + 0.0555032721F;
  power = power * rest + 0.240221074F;
  power = power * rest + 0.693147207F;
  power = power * rest + 1.0F;
  return power * std::bit_cast<float>(std::max(whole + 127, 0) << 23);
}

// Squared angle of the rotation between unit quaternions with 1 - |dot| = u in [0, 1]:
// (2 acos(1 - u))^2, to 3e-7 of it, exact at 0 where the arc cosine loses half the digits.
inline float SquaredAngle(float u) {
  float ratio = 0.0366719661F;  // Chebyshev fit of the squared angle over u on [0, 1].
  ratio = ratio * u - 0.0418018427F;
  ratio = ratio * u + 0.0861984233F;
  ratio = ratio * u + 0.096716446F;
  ratio = ratio * u + 0.358686593F;
  ratio = ratio * u + 1.33312773F;
  ratio = ratio * u + 8.00000218F;
  return ratio * u;
}

inline float Squared(float value) { return value * value; }

// Adds at most kBlock weights, in kLanes lanes each, so that a compiler may use vectors without
// changing the result.
void AddBlock(std::span<const float> weights, WeightSums* sums) {
  std::array<float, kLanes> sum{};
  std::array<float, kLanes> squares{};
  size_t i = 0;
  for (; i + kLanes <= weights.size(); i += kLanes) {
    for (size_t lane = 0; lane < kLanes; ++lane) {
      sum[lane] += weights[i + lane];
      squares[lane] += Squared(weights[i + lane]);
    }
  }
  for (; i < weights.size(); ++i) {
    sum[0] += weights[i];
    squares[0] += Squared(weights[i]);
  }
  for (size_t lane = 0; lane < kLanes; ++lane) {
    sums->sum += static_cast<double>(sum[lane]);
    sums->sum_of_squares += static_cast<double>(squares[lane]);
  }
}

}  // namespace

void SpreadEvenly(const Eigen::Quaterniond& turn, ParticleArrays* particles) {
  constexpr double kPhi = std::numbers::sqrt2;
  constexpr double kPsi = 1.533751168755204288118041;  // Root of psi^4 = psi + 4.
  const size_t count = particles->size();
  for (size_t i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) + 0.5;
    const double share = s / static_cast<double>(count);
    const double r = std::sqrt(share);
    const double R = std::sqrt(1.0 - share);
    const double alpha = 2.0 * std::numbers::pi * s / kPhi;
    const double beta = 2.0 * std::numbers::pi * s / kPsi;
    const Eigen::Vector4f q =
        (turn *
         Eigen::Quaterniond(
             R * std::cos(beta), r * std::sin(alpha), r * std::cos(alpha), R * std::sin(beta)))
            .normalized()
            .coeffs()
            .cast<float>();
    particles->x[i] = q[0];
    particles->y[i] = q[1];
    particles->z[i] = q[2];
    particles->w[i] = q[3];
    particles->weight[i] = 1.0F;
  }
}

WeightSums MultiplyByConfidence(const Eigen::Quaterniond& q,
                                double sigma,
                                float floor,
                                float scale,
                                ParticleArrays* particles) {
  const auto qx = static_cast<float>(q.x());
  const auto qy = static_cast<float>(q.y());
  const auto qz = static_cast<float>(q.z());
  const auto qw = static_cast<float>(q.w());
  const auto to_exponent = static_cast<float>(-0.5 * std::numbers::log2e / (sigma * sigma));
  const size_t count = particles->size();
  WeightSums sums;
  for (size_t begin = 0; begin < count; begin += kBlock) {
    const float* x = &particles->x[begin];
    const float* y = &particles->y[begin];
    const float* z = &particles->z[begin];
    const float* w = &particles->w[begin];
    float* weight = &particles->weight[begin];
    const size_t size = std::min(kBlock, count - begin);
    for (size_t i = 0; i < size; ++i) {
      // The nearer of q and -q; by differences, which keep their digits near 0.
      const float plus =
          Squared(x[i] - qx) + Squared(y[i] - qy) + Squared(z[i] - qz) + Squared(w[i] - qw);
      const float minus =
          Squared(x[i] + qx) + Squared(y[i] + qy) + Squared(z[i] + qz) + Squared(w[i] + qw);
      const float u = 0.5F * std::min(plus, minus);
      weight[i] *= scale * (Exp2(to_exponent * SquaredAngle(u)) + floor);
    }
    AddBlock({weight, size}, &sums);
  }
  return sums;
}

SystematicResampler::SystematicResampler(size_t count, Rng& rng)
    : draws_(count + 1), drawn_(count), turns_(kTurns) {
  for (std::vector<float>& normals : normals_) {
    for (size_t i = 0; i < kTurns; ++i) normals.push_back(static_cast<float>(rng.Normal()));
  }
}

void SystematicResampler::MakeTurns(double jitter) {
  const auto half = static_cast<float>(0.5 * jitter);
  for (size_t i = 0; i < kTurns; ++i) {
    const float x = half * normals_[0][i];
    const float y = half * normals_[1][i];
    const float z = half * normals_[2][i];
    const float scale = 1.0F / std::sqrt(1.0F + x * x + y * y + z * z);
    turns_.x[i] = scale * x;
    turns_.y[i] = scale * y;
    turns_.z[i] = scale * z;
    turns_.w[i] = scale;
  }
}

void SystematicResampler::Draw(const std::vector<float>& weights,
                               double weight_sum,
                               double offset) {
  const size_t count = drawn_.size();
  const double draws_per_weight = static_cast<double>(count) / weight_sum;
  std::fill(draws_.begin(), draws_.end(), 0);
  // Each particle writes where its draws begin; one without any is overwritten by the next.
  double cumulative = 1.0 - offset;
  size_t first = 0;
  for (size_t i = 0; i < count; ++i) {
    draws_[first] = static_cast<uint32_t>(i);
    cumulative += draws_per_weight * static_cast<double>(weights[i]);
    first = std::min(static_cast<size_t>(cumulative), count);
  }
  for (size_t j = 1; j < count; ++j) draws_[j] = std::max(draws_[j], draws_[j - 1]);
}

void SystematicResampler::Resample(double weight_sum,
                                   double jitter,
                                   Rng& rng,
                                   ParticleArrays* particles) {
  VANTAGE_CHECK(particles->size() == drawn_.size(), "resampling another number of particles");
  Draw(particles->weight, weight_sum, rng.Uniform());
  MakeTurns(jitter);
  std::array<std::array<float, kBlock>, 4> from{};
  const size_t count = drawn_.size();
  for (size_t begin = 0; begin < count; begin += kBlock) {
    const size_t size = std::min(kBlock, count - begin);
    for (size_t n = 0; n < size; ++n) {
      const size_t i = draws_[begin + n];
      from[0][n] = particles->x[i];
      from[1][n] = particles->y[i];
      from[2][n] = particles->z[i];
      from[3][n] = particles->w[i];
    }
    const size_t t = rng.Below(static_cast<uint32_t>(kTurns - kBlock + 1));
    const float* tx = &turns_.x[t];
    const float* ty = &turns_.y[t];
    const float* tz = &turns_.z[t];
    const float* tw = &turns_.w[t];
    float* rx = &drawn_.x[begin];
    float* ry = &drawn_.y[begin];
    float* rz = &drawn_.z[begin];
    float* rw = &drawn_.w[begin];
    for (size_t n = 0; n < size; ++n) {
      const float x = from[0][n];
      const float y = from[1][n];
      const float z = from[2][n];
      const float w = from[3][n];
      const float px = w * tx[n] + x * tw[n] + y * tz[n] - z * ty[n];
      const float py = w * ty[n] - x * tz[n] + y * tw[n] + z * tx[n];
      const float pz = w * tz[n] + x * ty[n] - y * tx[n] + z * tw[n];
      const float pw = w * tw[n] - x * tx[n] - y * ty[n] - z * tz[n];
      // The norm is 1 but for rounding: one Newton step of 1 / sqrt.
      const float scale = 1.5F - 0.5F * (px * px + py * py + pz * pz + pw * pw);
      rx[n] = scale * px;
      ry[n] = scale * py;
      rz[n] = scale * pz;
      rw[n] = scale * pw;
    }
  }
  std::fill(drawn_.weight.begin(), drawn_.weight.end(), 1.0F);
  std::swap(*particles, drawn_);
}

}  // namespace vantage
