#include "fusion/sphere_patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vantage {
namespace {

constexpr int kNumNodes = 16;

struct Quadrature {
  std::array<double, kNumNodes> node;    // In [0, 1].
  std::array<double, kNumNodes> weight;  // Sums to 1.
};

// Gauss-Legendre, after t -> t^2 (3 - 2 t), which makes square roots at either end smooth: the arcs
// of boxes that reach a coordinate plane begin like a square root.
Quadrature MakeQuadrature() {
  Quadrature quadrature{};
  for (int i = 0; i < kNumNodes; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (kNumNodes + 0.5));
    double slope = 1.0;
    for (int step = 0; step < 50; ++step) {
      double previous = 1.0;
      double value = x;
      for (int n = 2; n <= kNumNodes; ++n) {
        const double next = ((2 * n - 1) * x * value - (n - 1) * previous) / n;
        previous = value;
        value = next;
      }
      slope = kNumNodes * (x * value - previous) / (x * x - 1.0);
      x -= value / slope;
    }
    const double t = 0.5 * (1.0 + x);
    const auto slot = static_cast<size_t>(i);
    quadrature.node[slot] = t * t * (3.0 - 2.0 * t);
    quadrature.weight[slot] = 6.0 * t * (1.0 - t) / ((1.0 - x * x) * slope * slope);
  }
  return quadrature;
}

// The part of a circle about the origin that lies in the box [a, a + 1] x [b, b + 1].
struct Arc {
  double length;  // rad
  double cosine;  // Integral of the cosine over the arc.
  double sine;    // Integral of the sine over the arc.
};

Arc ArcInBox(double squared_radius, double a, double b) {
  const auto root = [](double value) { return std::sqrt(std::max(0.0, value)); };
  const double r = std::sqrt(squared_radius);
  // The arc begins on the side a + 1 or b and ends on the side b + 1 or a.
  const bool begins_right = squared_radius > (a + 1.0) * (a + 1.0) + b * b;
  const double begin_x = begins_right ? a + 1.0 : root(squared_radius - b * b);
  const double begin_y = begins_right ? root(squared_radius - begin_x * begin_x) : b;
  const bool ends_left = squared_radius < a * a + (b + 1.0) * (b + 1.0);
  const double end_x = ends_left ? a : root(squared_radius - (b + 1.0) * (b + 1.0));
  const double end_y = ends_left ? root(squared_radius - a * a) : b + 1.0;
  return {std::atan2(begin_x * end_y - begin_y * end_x, begin_x * end_x + begin_y * end_y),
          (end_y - begin_y) / r,
          (begin_x - end_x) / r};
}

// Squared radii at which the arc in a box begins, ends, or changes its sides.
std::array<int, 4> CornerRadii(int a, int b) {
  const auto square = [](int value) { return value * value; };
  return {square(a) + square(b),
          square(a + 1) + square(b),
          square(a) + square(b + 1),
          square(a + 1) + square(b + 1)};
}

// The cell's corner on the sphere, if the cell meets the sphere there alone.
Eigen::Vector4d TouchingCorner(const std::array<int, 4>& lower, int k) {
  const Eigen::Vector4i near(lower.data());
  const Eigen::Vector4i corner =
      near.squaredNorm() == k * k ? near : Eigen::Vector4i(near + Eigen::Vector4i::Ones());
  return corner.cast<double>().normalized();
}

}  // namespace

SpherePatch IntegrateSpherePatch(const std::array<int, 4>& lower, int k) {
  static const Quadrature kQuadrature = MakeQuadrature();
  const int total = k * k;  // Squared radius of the sphere in cells; s counts in the same unit.
  const std::array<int, 4> xy = CornerRadii(lower[0], lower[1]);
  const std::array<int, 4> zw = CornerRadii(lower[2], lower[3]);
  const int first = std::max(xy.front(), total - zw.back());
  const int last = std::min(xy.back(), total - zw.front());

  std::array<int, 8> breaks{};
  for (size_t i = 0; i < 4; ++i) {
    breaks[i] = std::clamp(xy[i], first, std::max(first, last));
    breaks[i + 4] = std::clamp(total - zw[i], first, std::max(first, last));
  }
  std::sort(breaks.begin(), breaks.end());

  double area = 0.0;
  Eigen::Vector4d moment = Eigen::Vector4d::Zero();
  for (size_t piece = 0; piece + 1 < breaks.size(); ++piece) {
    const double width = breaks[piece + 1] - breaks[piece];
    if (width == 0.0) continue;
    for (size_t i = 0; i < kNumNodes; ++i) {
      const double s = breaks[piece] + width * kQuadrature.node[i];
      const Arc a = ArcInBox(s, lower[0], lower[1]);
      const Arc b = ArcInBox(total - s, lower[2], lower[3]);
      const double weight = 0.5 * width * kQuadrature.weight[i];
      area += weight * a.length * b.length;
      moment += weight * Eigen::Vector4d(std::sqrt(s) * a.cosine * b.length,
                                         std::sqrt(s) * a.sine * b.length,
                                         std::sqrt(total - s) * b.cosine * a.length,
                                         std::sqrt(total - s) * b.sine * a.length);
    }
  }
  SpherePatch patch;
  patch.area = area / (total * std::numbers::pi * std::numbers::pi);
  patch.centroid = area > 0.0 ? moment.normalized() : TouchingCorner(lower, k);
  return patch;
}

}  // namespace vantage
