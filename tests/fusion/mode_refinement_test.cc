#include "fusion/mode_refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/orientation_filter.h"
#include "fusion/quaternion_mean.h"

namespace vantage {
namespace {

using Kernels = std::vector<OrientationKernel>;

Kernels Detections(const Eigen::Quaterniond& truth, double sigma, int count, Rng& rng) {
  Kernels detections;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    detections.push_back({truth * ExpSo3(sigma * error), 0.0, rng.Uniform(0.5, 2.0)});
  }
  return detections;
}

const SymmetryGroup kNone = SymmetryGroup::None();

TEST(ModeRefinement, ParametersAreChecked) {
  using Parameters = ModeRefinementParameters;
  EXPECT_TRUE(Parameters().Validate().ok());
  EXPECT_TRUE((Parameters{.bandwidth = 0.0}).Validate().ok());
  EXPECT_FALSE((Parameters{.sigma = 0.0}).Validate().ok());
  EXPECT_FALSE((Parameters{.sigma = INFINITY}).Validate().ok());
  EXPECT_FALSE((Parameters{.bandwidth = -1.0}).Validate().ok());
  EXPECT_FALSE((Parameters{.bandwidth = NAN}).Validate().ok());
  EXPECT_FALSE((Parameters{.smallest_sigma = 0.0}).Validate().ok());
  EXPECT_FALSE((Parameters{.smallest_sigma = 1.0}).Validate().ok());
  EXPECT_FALSE((Parameters{.mse_floor = 0.0}).Validate().ok());
  EXPECT_FALSE((Parameters{.mse_floor = INFINITY}).Validate().ok());
}

TEST(ModeRefinement, PrecisionIsTheInverseOfTheError) {
  const ModeRefinementParameters parameters{.mse_floor = 1e-7};
  EXPECT_NEAR(PrecisionWeight(0.0, parameters), 10.0, 1e-12);
  EXPECT_NEAR(PrecisionWeight(9e-7, parameters), 1.0, 1e-12);
  EXPECT_GT(PrecisionWeight(1e6, parameters), 0.0);
}

// Without a symmetry and with kernels of one width it is the density's mode and no more.
TEST(ModeRefinement, OfFixedWidthIsTheDensitysMode) {
  Rng rng(1);
  const ModeRefinementParameters parameters{.bandwidth = 0.0};
  for (int i = 0; i < 20; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    Kernels detections = Detections(truth, 1.5 * kDegree, 15, rng);
    for (OrientationKernel& detection : detections) detection.sigma = rng.Uniform(0.0, 0.1);
    Kernels kernels = detections;
    for (OrientationKernel& kernel : kernels) {
      kernel.sigma = std::sqrt(kernel.sigma * kernel.sigma + parameters.sigma * parameters.sigma);
    }
    const DensityMode expected = FindDensityMode(kernels, truth);
    const DensityMode mode = RefineMode(detections, truth, parameters, kNone);
    EXPECT_LT(GeodesicAngle(mode.q, expected.q), 1e-9);
    EXPECT_NEAR(mode.density, expected.density, 1e-9 * expected.density);
  }
}

// Narrow kernels keep every detection's weight, wide ones would too: about a single tight cluster
// the mode is near the weighted mean, whatever the scale of its scatter.
TEST(ModeRefinement, TheKernelsFollowTheScatter) {
  Rng rng(2);
  for (const double sigma_deg : {0.1, 0.5, 1.0}) {
    double square_sum = 0.0;
    constexpr int kTrials = 40;
    constexpr int kCount = 50;
    for (int trial = 0; trial < kTrials; ++trial) {
      const Eigen::Quaterniond truth = rng.Rotation();
      const Kernels detections = Detections(truth, sigma_deg * kDegree, kCount, rng);
      const DensityMode mode = RefineMode(detections, truth, {}, kNone);
      square_sum += std::pow(GeodesicAngle(mode.q, truth) / kDegree, 2);
    }
    // The mean's standard error in three axes is sigma sqrt(3 / 50), with uneven weights some more.
    const double expected = sigma_deg * std::sqrt(3.0 / kCount);
    EXPECT_LT(std::sqrt(square_sum / kTrials), 1.35 * expected) << sigma_deg;
    EXPECT_GT(std::sqrt(square_sum / kTrials), 0.7 * expected) << sigma_deg;
  }
}

// A third of the detections is wrong in the same direction by some degrees: too near for clusters
// to part them, yet wide enough to pull a mean away.
TEST(ModeRefinement, OutliersNearbyDoNotPullIt) {
  Rng rng(3);
  double worst_of_mode = 0.0;
  double best_of_mean = 180.0;
  for (int trial = 0; trial < 40; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    Kernels detections = Detections(truth, 0.3 * kDegree, 35, rng);
    const Eigen::Vector3d axis = rng.UnitVector();
    for (int i = 0; i < 15; ++i) {
      const Eigen::Vector3d wrong = rng.Uniform(3.0, 8.0) * kDegree * axis;
      detections.push_back({truth * ExpSo3(wrong), 0.0, 1.0});
    }
    std::vector<WeightedOrientation> all;
    for (const OrientationKernel& detection : detections) {
      all.push_back({detection.q, detection.weight});
    }
    const Eigen::Quaterniond mean = WeightedMean(all);
    const DensityMode mode = RefineMode(detections, mean, {}, kNone);
    worst_of_mode = std::max(worst_of_mode, GeodesicAngle(mode.q, truth) / kDegree);
    best_of_mean = std::min(best_of_mean, GeodesicAngle(mean, truth) / kDegree);
  }
  EXPECT_LT(worst_of_mode, 0.4);
  EXPECT_GT(best_of_mean, 0.9);
}

// Detections that any element of the group has turned are folded back onto those that none has.
TEST(ModeRefinement, FoldsFiniteSymmetries) {
  Rng rng(4);
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -0.5).normalized();
  for (const SymmetryGroup& group : {SymmetryGroup::Cyclic(2, axis),
                                     SymmetryGroup::Cyclic(5, axis),
                                     SymmetryGroup::Dihedral(2, axis, axis.unitOrthogonal()),
                                     SymmetryGroup::Dihedral(4, axis, axis.unitOrthogonal())}) {
    for (int trial = 0; trial < 10; ++trial) {
      const Eigen::Quaterniond truth = rng.Rotation();
      const Kernels plain = Detections(truth, 0.8 * kDegree, 20, rng);
      Kernels turned = plain;
      const auto order = static_cast<uint32_t>(group.elements.size());
      for (OrientationKernel& kernel : turned) {
        kernel.q = kernel.q * group.elements[rng.Below(order)];
      }
      const DensityMode expected = RefineMode(plain, truth, {}, kNone);
      const Eigen::Quaterniond start = truth * group.elements[rng.Below(order)];
      const DensityMode mode = RefineMode(turned, start, {}, group);
      EXPECT_LT(SymmetricAngle(group, mode.q, expected.q), 1e-8);
      EXPECT_LT(GeodesicAngle(mode.q, start), 2.0 * kDegree);  // Of all equal ones the nearest.
      EXPECT_NEAR(mode.density, expected.density, 1e-6 * expected.density);
      EXPECT_NEAR(
          mode.covariance.trace(), expected.covariance.trace(), 1e-6 * expected.covariance.trace());
    }
  }
}

// Only the axis matters, and whether it points up or down where the object flips.
TEST(ModeRefinement, FoldsContinuousSymmetries) {
  Rng rng(5);
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -1.0, 0.4).normalized();
  for (const bool flips : {false, true}) {
    const SymmetryGroup group = SymmetryGroup::Continuous(axis, flips);
    for (int trial = 0; trial < 10; ++trial) {
      const Eigen::Quaterniond truth = rng.Rotation();
      constexpr double kSigma = 0.8 * kDegree;
      constexpr int kCount = 40;
      Kernels detections = Detections(truth, kSigma, kCount, rng);
      Eigen::Vector3d axis_sum = Eigen::Vector3d::Zero();
      for (OrientationKernel& detection : detections) {
        detection.weight = 1.0;
        axis_sum += detection.q * axis;
        detection.q = detection.q * ExpSo3(rng.Uniform(-3.14, 3.14) * axis);
        if (flips && rng.Below(2) == 0) {
          detection.q = detection.q * ExpSo3(M_PI * axis.unitOrthogonal());
        }
      }
      const Eigen::Quaterniond start = truth * ExpSo3(2.0 * kDegree * rng.UnitVector());
      const DensityMode mode = RefineMode(detections, start, {}, group);
      const auto axis_angle = [&](const Eigen::Vector3d& wanted) {
        return std::atan2((mode.q * axis).cross(wanted).norm(), (mode.q * axis).dot(wanted));
      };
      // Within the scatter of its own directions' mean.
      EXPECT_LT(axis_angle(axis_sum), 0.5 * kSigma);
      EXPECT_LT(axis_angle(truth * axis), 4.0 * kSigma * std::sqrt(2.0 / kCount));
      // The twist is that of the start, about which the detections say nothing.
      EXPECT_LT(GeodesicAngle(mode.q, start), 4.0 * kDegree);
      const Eigen::Vector3d world_axis = mode.q * axis;
      EXPECT_LT(world_axis.dot(mode.covariance * world_axis), 1e-3 * mode.covariance.trace());
    }
  }
}

TEST(ModeRefinement, WhatIsUncertainCountsLess) {
  Rng rng(6);
  const Eigen::Quaterniond sure = rng.Rotation();
  const Eigen::Quaterniond unsure = sure * ExpSo3({3.0 * kDegree, 0.0, 0.0});
  const Kernels detections = {{sure, 0.0, 1.0}, {unsure, 6.0 * kDegree, 1.0}};
  const DensityMode mode = RefineMode(detections, unsure, {.bandwidth = 0.0}, kNone);
  EXPECT_LT(GeodesicAngle(mode.q, sure), 0.6 * kDegree);
  // Symmetric: equally uncertain they meet in the middle.
  const Kernels equal = {{sure, 6.0 * kDegree, 1.0}, {unsure, 6.0 * kDegree, 1.0}};
  const DensityMode middle = RefineMode(equal, unsure, {.bandwidth = 0.0}, kNone);
  EXPECT_NEAR(GeodesicAngle(middle.q, sure) / kDegree, 1.5, 1e-6);
}

TEST(ModeRefinement, FarFromAllDetectionsTheStartComesBack) {
  const Eigen::Quaterniond start = ExpSo3({0.3, 0.1, 0.0});
  const Kernels far = {{start * ExpSo3({0.0, 3.1, 0.0}), 0.0, 1.0}};
  for (const Kernels& detections : {Kernels{}, far}) {
    const DensityMode mode = RefineMode(detections, start, {}, kNone);
    EXPECT_LT(GeodesicAngle(mode.q, start), 1e-12);
    EXPECT_EQ(mode.density, 0.0);
  }
}

// A camera and an object at rest: the same detection with every frame.
TEST(ModeRefinement, RepeatedDetectionsCostNoMoreThanOne) {
  const So3Grid grid(8);
  OrientationFilter filter(grid, {});
  const Eigen::Quaterniond q = ExpSo3({0.4, -1.1, 0.7});
  const Eigen::Quaterniond other = q * ExpSo3({0.0, 3.0 * kDegree, 0.0});
  ASSERT_TRUE(filter.Add({other, 1e-6}).ok());
  for (int i = 0; i < 200'000; ++i) ASSERT_TRUE(filter.Add({q, 1e-6}).ok());
  EXPECT_LT(GeodesicAngle(*filter.Estimate(), q), 1e-4 * kDegree);
  EXPECT_TRUE(filter.converged());
  EXPECT_LT(filter.last_change(), 1e-9);
}

}  // namespace
}  // namespace vantage
