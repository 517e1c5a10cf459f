#include "fusion/density_mode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"

namespace vantage {
namespace {

using Kernels = std::vector<OrientationKernel>;

// The density of density_mode.h, by angles alone.
double Density(const Kernels& kernels, const Eigen::Quaterniond& q) {
  double density = 0.0;
  for (const OrientationKernel& kernel : kernels) {
    const double d = GeodesicAngle(kernel.q, q) / kernel.sigma;
    density += kernel.weight * std::exp(-0.5 * d * d) / std::pow(kernel.sigma, 3);
  }
  return density;
}

// Detections about a truth, of differing widths and weights.
Kernels RandomKernels(const Eigen::Quaterniond& truth, int count, Rng& rng) {
  Kernels kernels;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    kernels.push_back({truth * ExpSo3(2.0 * kDegree * error),
                       rng.Uniform(3.0, 6.0) * kDegree,
                       rng.Uniform(0.2, 2.0)});
  }
  return kernels;
}

// Central differences along the world's axes.
Eigen::Vector3d Gradient(const Kernels& kernels, const Eigen::Quaterniond& q) {
  constexpr double kStep = 1e-4;
  Eigen::Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Quaterniond step = ExpSo3(kStep * Eigen::Vector3d::Unit(axis));
    gradient[axis] =
        (Density(kernels, step * q) - Density(kernels, step.conjugate() * q)) / (2.0 * kStep);
  }
  return gradient;
}

TEST(DensityMode, OneKernelIsItsOwnMode) {
  Rng rng(1);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    const double sigma = rng.Uniform(0.5, 8.0) * kDegree;
    const Kernels kernel = {{q, sigma, 0.7}};
    const DensityMode mode =
        FindDensityMode(kernel, q * ExpSo3(rng.Uniform(0.0, 3.0) * sigma * rng.UnitVector()));
    EXPECT_LT(GeodesicAngle(mode.q, q), 1e-9);
    EXPECT_GE(mode.q.w(), 0.0);
    EXPECT_NEAR(mode.density, 0.7 / std::pow(sigma, 3), 1e-9 * mode.density);
    EXPECT_LT(mode.covariance.norm(), 1e-17);
  }
}

TEST(DensityMode, TheGradientIsZero) {
  Rng rng(2);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const Kernels kernels = RandomKernels(truth, 12, rng);
    const DensityMode mode = FindDensityMode(kernels, truth);
    EXPECT_NEAR(mode.density, Density(kernels, mode.q), 1e-9 * mode.density);
    // Against the slope of a kernel at its steepest, density / sigma.
    EXPECT_LT(Gradient(kernels, mode.q).norm(), 1e-6 * mode.density / (4.0 * kDegree));
  }
}

// No place of a lattice about the mode has a higher density, be it coarse or fine.
TEST(DensityMode, IsTheMaximumOfALattice) {
  Rng rng(3);
  for (int trial = 0; trial < 6; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const Kernels kernels = RandomKernels(truth, 8, rng);
    const DensityMode mode = FindDensityMode(kernels, truth);
    for (const double step_deg : {0.3, 0.01}) {
      constexpr int kSteps = 8;
      double highest = 0.0;
      Eigen::Vector3i at;
      for (int x = -kSteps; x <= kSteps; ++x) {
        for (int y = -kSteps; y <= kSteps; ++y) {
          for (int z = -kSteps; z <= kSteps; ++z) {
            const Eigen::Vector3d r(x, y, z);
            const double density = Density(kernels, ExpSo3(step_deg * kDegree * r) * mode.q);
            if (density <= highest) continue;
            highest = density;
            at = {x, y, z};
          }
        }
      }
      EXPECT_EQ(at, Eigen::Vector3i::Zero()) << step_deg;
    }
  }
}

TEST(DensityMode, TurnsWithTheDetections) {
  Rng rng(4);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const Eigen::Quaterniond turn = rng.Rotation();
    const Kernels kernels = RandomKernels(truth, 9, rng);
    Kernels left = kernels;
    Kernels right = kernels;
    for (OrientationKernel& kernel : left) kernel.q = turn * kernel.q;
    for (OrientationKernel& kernel : right) kernel.q = kernel.q * turn;
    const DensityMode mode = FindDensityMode(kernels, truth);
    const DensityMode turned = FindDensityMode(left, turn * truth);
    const DensityMode of_turned = FindDensityMode(right, truth * turn);
    EXPECT_LT(GeodesicAngle(turned.q, turn * mode.q), 1e-8);
    EXPECT_LT(GeodesicAngle(of_turned.q, mode.q * turn), 1e-8);
    // The covariance is in the world's axes: they turn with the world, not with the object's.
    const Eigen::Matrix3d R = turn.toRotationMatrix();
    const double size = mode.covariance.norm();
    EXPECT_LT((turned.covariance - R * mode.covariance * R.transpose()).norm(), 1e-6 * size);
    EXPECT_LT((of_turned.covariance - mode.covariance).norm(), 1e-6 * size);
    EXPECT_NEAR(turned.density, mode.density, 1e-9 * mode.density);
  }
}

TEST(DensityMode, IgnoresTheSideAndTheOrderOfTheQuaternions) {
  Rng rng(5);
  for (int i = 0; i < 40; ++i) {
    Eigen::Quaterniond truth = rng.Rotation();
    if (i % 2 == 0) truth.w() = 1e-3 * rng.Normal();  // About half turns the signs change.
    truth.normalize();
    Kernels kernels = RandomKernels(truth, 9, rng);
    const DensityMode mode = FindDensityMode(kernels, truth);
    for (OrientationKernel& kernel : kernels) {
      if (rng.Below(2) == 0) kernel.q.coeffs() *= -1.0;
    }
    const DensityMode same = FindDensityMode(kernels, Eigen::Quaterniond(-truth.coeffs()));
    EXPECT_EQ(same.q.coeffs(), mode.q.coeffs());
    EXPECT_EQ(same.covariance, mode.covariance);
    std::reverse(kernels.begin(), kernels.end());
    EXPECT_LT(GeodesicAngle(FindDensityMode(kernels, truth).q, mode.q), 1e-9);
  }
}

TEST(DensityMode, TheWayThereDoesNotMatter) {
  Rng rng(6);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const Kernels kernels = RandomKernels(truth, 9, rng);
    const DensityMode mode = FindDensityMode(kernels, truth);
    const Eigen::Quaterniond elsewhere = truth * ExpSo3(5.0 * kDegree * rng.UnitVector());
    EXPECT_LT(GeodesicAngle(FindDensityMode(kernels, elsewhere).q, mode.q), 1e-8);
  }
}

TEST(DensityMode, CovarianceIsThatOfTheWeightedDetections) {
  Rng rng(7);
  const Eigen::Quaterniond truth = rng.Rotation();
  const Kernels kernels = RandomKernels(truth, 25, rng);
  const DensityMode mode = FindDensityMode(kernels, truth);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double sum = 0.0;
  for (const OrientationKernel& kernel : kernels) {
    // The rotation vector by Eigen's own conversion.
    const Eigen::AngleAxisd difference(kernel.q.toRotationMatrix() *
                                       mode.q.toRotationMatrix().transpose());
    const Eigen::Vector3d r = difference.angle() * difference.axis();
    const double height = Density({kernel}, mode.q);
    covariance += height * r * r.transpose();
    sum += height;
  }
  covariance /= sum;
  EXPECT_LT((mode.covariance - covariance).norm(), 1e-9 * covariance.norm());
}

TEST(DensityMode, FindsTheOneOfTwoThatIsNearer) {
  Rng rng(8);
  const Eigen::Quaterniond a = rng.Rotation();
  const Eigen::Quaterniond b = a * ExpSo3(1.0 * rng.UnitVector());
  const Kernels kernels = {{a, 0.07, 1.0}, {b, 0.07, 3.0}};
  EXPECT_LT(GeodesicAngle(FindDensityMode(kernels, a * ExpSo3({0.1, 0.0, 0.0})).q, a), 1e-6);
  EXPECT_LT(GeodesicAngle(FindDensityMode(kernels, b * ExpSo3({0.1, 0.0, 0.0})).q, b), 1e-6);
}

TEST(DensityMode, FarFromAllKernelsTheStartComesBack) {
  const Eigen::Quaterniond start = ExpSo3({0.1, 0.2, 0.3});
  const Kernels far = {{start * ExpSo3({3.0, 0.0, 0.0}), 0.05, 1.0}};
  const Kernels weightless = {{start, 0.05, 0.0}};
  for (const Kernels& kernels : {Kernels{}, far, weightless}) {
    const DensityMode mode = FindDensityMode(kernels, Eigen::Quaterniond(-start.coeffs()));
    EXPECT_LT(GeodesicAngle(mode.q, start), 1e-15);
    EXPECT_GE(mode.q.w(), 0.0);
    EXPECT_EQ(mode.density, 0.0);
    EXPECT_TRUE(mode.covariance.allFinite());
  }
}

}  // namespace
}  // namespace vantage
