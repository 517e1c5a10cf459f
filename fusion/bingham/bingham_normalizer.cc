#include "fusion/bingham/bingham_normalizer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

/// exp(-x) I_0(x) and exp(-x) (I_0(x) - I_1(x)), x >= 0, for modified Bessel functions.
struct ScaledBessel {
  double i0;
  double i0_minus_i1;
};

constexpr int kPowerTerms = 46;   // Leaves 1e-17 at x = 20.
constexpr int kHankelTerms = 26;  // Leaves 1e-16 at x = 20.

struct BesselCoefficients {
  std::array<double, kPowerTerms> power0;         // 1 / (k!)^2
  std::array<double, kPowerTerms> power1;         // 1 / (k! (k+1)!)
  std::array<double, kHankelTerms> hankel0;       // of I_0, in powers of 1/x
  std::array<double, kHankelTerms> hankel_minus;  // of I_0 - I_1
};

constexpr BesselCoefficients MakeBesselCoefficients() {
  BesselCoefficients c{};
  c.power0[0] = 1.0;
  c.power1[0] = 1.0;
  for (size_t k = 1; k < kPowerTerms; ++k) {
    const auto n = static_cast<double>(k);
    c.power0[k] = c.power0[k - 1] / (n * n);
    c.power1[k] = c.power1[k - 1] / (n * (n + 1.0));
  }
  double hankel1 = 1.0;
  c.hankel0[0] = 1.0;
  for (size_t k = 1; k < kHankelTerms; ++k) {
    const auto n = static_cast<double>(k);
    const double odd_squared = (2.0 * n - 1.0) * (2.0 * n - 1.0);
    c.hankel0[k] = c.hankel0[k - 1] * odd_squared / (8.0 * n);
    hankel1 *= (odd_squared - 4.0) / (8.0 * n);
    c.hankel_minus[k] = c.hankel0[k] - hankel1;
  }
  return c;
}

constexpr BesselCoefficients kBessel = MakeBesselCoefficients();

template <size_t N>
double Horner(const std::array<double, N>& coefficients, double x, size_t num_terms = N) {
  double sum = 0.0;
  for (size_t k = num_terms; k-- > 0;) sum = sum * x + coefficients[k];
  return sum;
}

ScaledBessel ComputeScaledBessel(double x) {
  if (x < 20.0) {
    const double y = 0.25 * x * x;
    const size_t num_terms = x < 2.0 ? 12 : kPowerTerms;
    const double scale = std::exp(-x);
    const double i0 = scale * Horner(kBessel.power0, y, num_terms);
    return {i0, i0 - scale * 0.5 * x * Horner(kBessel.power1, y, num_terms)};
  }
  const double scale = 1.0 / std::sqrt(2.0 * kPi * x);
  return {scale * Horner(kBessel.hankel0, 1.0 / x), scale * Horner(kBessel.hankel_minus, 1.0 / x)};
}

/// Of the double exponential quadrature over (0, 1): Takahasi and Mori, 1974.
struct Node {
  double x;
  double one_minus_x;
  double weight;
};

std::vector<Node> MakeNodes() {
  constexpr double kStep = 0.05;
  std::vector<Node> nodes;
  for (int i = -68; i <= 68; ++i) {
    const double t = kStep * i;
    const double e = std::exp(-kPi * std::sinh(t));
    const double x = 1.0 / (1.0 + e);
    const double one_minus_x = 1.0 / (1.0 + 1.0 / e);
    nodes.push_back({x, one_minus_x, kStep * kPi * std::cosh(t) * x * one_minus_x});
  }
  return nodes;
}

/// First and second moments of the squares of the two coordinates on a circle of squared radius
/// `r2`, under exp(-2 kappa cos^2(a)).
struct Circle {
  double low, high;
  double low_low, low_high, high_high;

  Circle(double r2, double kappa, const ScaledBessel& bessel) {
    const double minus_cos = 1.0 - bessel.i0_minus_i1 / bessel.i0;  // -E[cos 2a] = I_1 / I_0
    // E[cos^2 2a] = (1 + I_2 / I_0) / 2.
    const double cos_squared = kappa < 1e-3 ? 0.5 + kappa * kappa / 16.0 : 1.0 - minus_cos / kappa;
    low = 0.5 * r2 * bessel.i0_minus_i1 / bessel.i0;
    high = r2 - low;
    low_high = 0.25 * r2 * r2 * (1.0 - cos_squared);
    low_low = r2 * low - low_high;
    high_high = r2 * high - low_high;
  }
};

/// q = (sqrt(s) (cos a, sin a), sqrt(1 - s) (cos b, sin b)), surface element ds da db / 2:
/// F = 2 pi^2 int exp(s z_2) e^-k I_0(k) e^-l I_0(l) ds, k = s (z_2 - z_1) / 2, l = -(1-s) z_3 / 2.
/// @param z ascending, z_4 = 0.
BinghamIntegrals Integrate(const Eigen::Vector4d& z) {
  static const std::vector<Node> nodes = MakeNodes();
  const double reach = std::min(1.0, -40.0 / std::min(z[1], -1e-300));
  // Every other node is enough where I_0(k) has no scale much shorter than exp(s z_2).
  const size_t stride = reach * (z[1] - z[0]) > 100.0 ? 1 : 2;
  double sum = 0.0;
  Eigen::Vector4d first = Eigen::Vector4d::Zero();
  Eigen::Matrix4d second = Eigen::Matrix4d::Zero();
  for (size_t i = 0; i < nodes.size(); i += stride) {
    const Node& node = nodes[i];
    const double s = reach * node.x;
    const double rest = reach < 1.0 ? 1.0 - s : node.one_minus_x;
    const double kappa = 0.5 * s * (z[1] - z[0]);
    const double lambda = -0.5 * rest * z[2];
    const ScaledBessel bessel_s = ComputeScaledBessel(kappa);
    const ScaledBessel bessel_rest = ComputeScaledBessel(lambda);
    const double value = node.weight * std::exp(s * z[1]) * bessel_s.i0 * bessel_rest.i0;
    const Circle outer(s, kappa, bessel_s);
    const Circle inner(rest, lambda, bessel_rest);
    sum += value;
    first += value * Eigen::Vector4d(outer.low, outer.high, inner.low, inner.high);
    second(0, 0) += value * outer.low_low;
    second(0, 1) += value * outer.low_high;
    second(1, 1) += value * outer.high_high;
    second(2, 2) += value * inner.low_low;
    second(2, 3) += value * inner.low_high;
    second(3, 3) += value * inner.high_high;
    second(0, 2) += value * outer.low * inner.low;
    second(0, 3) += value * outer.low * inner.high;
    second(1, 2) += value * outer.high * inner.low;
    second(1, 3) += value * outer.high * inner.high;
  }
  BinghamIntegrals result;
  result.log_normalizer = std::log(2.0 * kPi * kPi * reach * static_cast<double>(stride) * sum);
  result.mean = first / sum;
  const Eigen::Matrix4d full = second.selfadjointView<Eigen::Upper>();
  result.covariance = full / sum - result.mean * result.mean.transpose();
  return result;
}

/// F = 2 int exp(z_1 y_1^2 + z_2 y_2^2 + z_3 y_3^2) / sqrt(1 - y^2) dy over the unit ball. With the
/// root expanded, the terms are Gaussian moments E[y^(2k)] = k! 2^k h_k, with the generating
/// function sum h_k t^k = prod (1 - v_i t)^(-1/2), where v_i = -1 / (2 z_i).
/// @param z ascending, z_4 = 0, z_3 << 0.
BinghamIntegrals Expand(const Eigen::Vector4d& z) {
  constexpr int kTerms = 19;
  const Eigen::Vector3d v = -0.5 * z.head<3>().cwiseInverse();
  std::array<double, kTerms> h{};
  std::array<double, kTerms> power_sum{};
  double total = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();   // d total / d v_i
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // its derivatives
  Eigen::Vector3d a = Eigen::Vector3d::Zero();       // coefficients of prod / (1 - v_i t)
  Eigen::Matrix3d b = Eigen::Matrix3d::Zero();       // and of prod / ((1 - v_i t) (1 - v_j t))
  Eigen::Vector3d powers = Eigen::Vector3d::Ones();
  Eigen::Vector3d a_before = Eigen::Vector3d::Zero();
  Eigen::Matrix3d b_before = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d b_before_that = Eigen::Matrix3d::Zero();
  double scale = 1.0;  // k! 2^k times the k-th coefficient of 1 / sqrt(1 - x): (2k - 1)!!
  for (size_t k = 0; k < kTerms; ++k) {
    const auto n = static_cast<double>(k);
    if (k == 0) {
      h[0] = 1.0;
    } else {
      scale *= 2.0 * n - 1.0;
      powers = powers.cwiseProduct(v);
      power_sum[k] = powers.sum();
      for (size_t j = 1; j <= k; ++j) h[k] += power_sum[j] * h[k - j];
      h[k] /= 2.0 * n;
    }
    total += scale * h[k];
    first += (0.5 * scale) * a_before;
    second += (0.25 * scale) * b_before_that;
    a = Eigen::Vector3d::Constant(h[k]) + v.cwiseProduct(a_before);
    b_before_that = b_before;
    b = (a * Eigen::RowVector3d::Ones()) + b_before * v.asDiagonal();
    a_before = a;
    b_before = b;
  }
  second.diagonal() *= 3.0;

  BinghamIntegrals result;
  result.log_normalizer = std::log(2.0 * total) + 1.5 * std::log(kPi) -
                          0.5 * (std::log(-z[0]) + std::log(-z[1]) + std::log(-z[2]));
  const Eigen::Vector3d gradient = first / total;
  const Eigen::Vector3d dv_dz = 2.0 * v.cwiseProduct(v);
  result.mean.head<3>() = v + dv_dz.cwiseProduct(gradient);
  result.mean[3] = 1.0 - result.mean.head<3>().sum();
  Eigen::Matrix3d covariance =
      dv_dz.asDiagonal() * (second / total - gradient * gradient.transpose()) * dv_dz.asDiagonal();
  covariance.diagonal() += dv_dz + 4.0 * dv_dz.cwiseProduct(v).cwiseProduct(gradient);
  result.covariance.topLeftCorner<3, 3>() = covariance;
  result.covariance.topRightCorner<3, 1>() = -covariance.rowwise().sum();
  result.covariance.bottomLeftCorner<1, 3>() = -covariance.colwise().sum();
  result.covariance(3, 3) = covariance.sum();
  return result;
}

}  // namespace

BinghamIntegrals ComputeBinghamIntegrals(const Eigen::Vector4d& z) {
  std::array<Eigen::Index, 4> order{0, 1, 2, 3};
  std::sort(
      order.begin(), order.end(), [&z](Eigen::Index a, Eigen::Index b) { return z[a] < z[b]; });
  const double largest = z[order[3]];
  const Eigen::Vector4d sorted = z(order).array() - largest;
  constexpr double kConcentrated = -60.0;
  const BinghamIntegrals in_order = sorted[2] <= kConcentrated ? Expand(sorted) : Integrate(sorted);
  BinghamIntegrals result;
  result.log_normalizer = in_order.log_normalizer + largest;
  result.mean(order) = in_order.mean;
  result.covariance(order, order) = in_order.covariance;
  return result;
}

}  // namespace vantage
