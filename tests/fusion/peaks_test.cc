#include "fusion/peaks.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/quaternion_mean.h"

namespace vantage {
namespace {

constexpr double kSigma = 4.0 * kDegree;

// A detection: the truth turned by a normal error of `sigma` in each of three axes.
Eigen::Quaterniond Perturbed(const Eigen::Quaterniond& q, double sigma, Rng& rng) {
  return q * ExpSo3(sigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
}

TEST(Peaks, EmptyHistogramHasNone) {
  const So3Grid grid(8);
  EXPECT_TRUE(FindPeaks(OrientationHistogram(grid), {}).empty());
}

TEST(Peaks, OneDetectionIsFoundWithinTheGridsAccuracy) {
  const So3Grid grid(32);
  Rng rng(1);
  double sum = 0.0;
  constexpr int kTrials = 300;
  for (int i = 0; i < kTrials; ++i) {
    Eigen::Quaterniond q = rng.Rotation();
    if (i % 3 == 0) q.w() = 1e-3 * rng.Normal();  // The peak then spans w = 0.
    q.normalize();
    OrientationHistogram histogram(grid);
    histogram.Add(q, kSigma, 1.0);
    const std::vector<OrientationPeak> peaks = FindPeaks(histogram, {});
    ASSERT_EQ(peaks.size(), 1U);
    const double error = GeodesicAngle(peaks.front().q, q) / kDegree;
    sum += error;
    ASSERT_LT(error, 1.5);
    EXPECT_GT(peaks.front().weight, 0.02);
    EXPECT_LT(peaks.front().spread, kSigma);
  }
  EXPECT_LT(sum / kTrials, 0.7);
}

TEST(Peaks, ManyDetectionsAverageOut) {
  const So3Grid grid(32);
  Rng rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    OrientationHistogram histogram(grid);
    for (int i = 0; i < 40; ++i) histogram.Add(Perturbed(truth, 2.0 * kDegree, rng), kSigma, 1.0);
    EXPECT_LT(GeodesicAngle(FindPeaks(histogram, {}).front().q, truth) / kDegree, 1.3);
  }
}

TEST(Peaks, TurningTheDetectionsTurnsThePeak) {
  const So3Grid grid(32);
  Rng rng(3);
  std::vector<Eigen::Quaterniond> detections;
  const Eigen::Quaterniond truth = rng.Rotation();
  for (int i = 0; i < 12; ++i) detections.push_back(Perturbed(truth, 2.0 * kDegree, rng));
  const auto fuse = [&](const Eigen::Quaterniond& turn) {
    OrientationHistogram histogram(grid);
    for (const Eigen::Quaterniond& q : detections) histogram.Add(turn * q, kSigma, 1.0);
    return FindPeaks(histogram, {}).front().q;
  };
  const Eigen::Quaterniond reference = fuse(Eigen::Quaterniond::Identity());
  for (int i = 0; i < 50; ++i) {
    const Eigen::Quaterniond turn = rng.Rotation();
    EXPECT_LT(GeodesicAngle(fuse(turn), turn * reference) / kDegree, 1.6);
  }
}

TEST(Peaks, TwoModesGiveTwoPeaks) {
  const So3Grid grid(32);
  Rng rng(4);
  const Eigen::Quaterniond first = rng.Rotation();
  const Eigen::Quaterniond second = first * ExpSo3(Eigen::Vector3d(0.0, 0.0, M_PI));
  OrientationHistogram histogram(grid);
  for (int i = 0; i < 10; ++i) histogram.Add(Perturbed(first, 1.0 * kDegree, rng), kSigma, 1.0);
  for (int i = 0; i < 6; ++i) histogram.Add(Perturbed(second, 1.0 * kDegree, rng), kSigma, 1.0);
  const std::vector<OrientationPeak> peaks = FindPeaks(histogram, {});
  ASSERT_EQ(peaks.size(), 2U);
  EXPECT_LT(GeodesicAngle(peaks[0].q, first) / kDegree, 1.5);
  EXPECT_LT(GeodesicAngle(peaks[1].q, second) / kDegree, 1.5);
  EXPECT_GT(peaks[0].weight, peaks[1].weight);
  // The same mass in each: both clusters are the paper's.
  for (int i = 0; i < 4; ++i) histogram.Add(second, kSigma, 1.0);
  EXPECT_EQ(FindPeaks(histogram, {}).size(), 2U);
}

TEST(Peaks, AWrongMinorityDoesNotMoveThePeak) {
  const So3Grid grid(32);
  Rng rng(5);
  const Eigen::Quaterniond truth = rng.Rotation();
  OrientationHistogram histogram(grid);
  for (int i = 0; i < 8; ++i) histogram.Add(Perturbed(truth, 1.0 * kDegree, rng), kSigma, 1.0);
  const Eigen::Quaterniond before = FindPeaks(histogram, {}).front().q;
  for (int i = 0; i < 5; ++i) {
    const Eigen::Quaterniond wrong = truth * ExpSo3(rng.Uniform(0.6, 3.0) * rng.UnitVector());
    histogram.Add(wrong, kSigma, 1.0);
  }
  EXPECT_LT(GeodesicAngle(FindPeaks(histogram, {}).front().q, before), 1e-9);
}

TEST(Peaks, AShoulderIsNoMode) {
  const So3Grid grid(32);
  const Eigen::Quaterniond q(0.8, 0.2, -0.4, 0.4);
  OrientationHistogram histogram(grid);
  histogram.Add(q.normalized(), kSigma, 1.0);
  histogram.Add(q.normalized() * ExpSo3(Eigen::Vector3d(1.2 * kSigma, 0.0, 0.0)), kSigma, 0.6);
  EXPECT_EQ(FindPeaks(histogram, {}).size(), 1U);
}

// Of the cells that are as high as w_min of the highest one, in the world's axes.
TEST(Peaks, CovarianceIsThatOfTheClustersCells) {
  const So3Grid grid(32);
  Rng rng(7);
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    // A ridge along one axis of the object, whose direction the covariance must show.
    const Eigen::Vector3d axis = rng.UnitVector();
    OrientationHistogram histogram(grid);
    for (int i = -6; i <= 6; ++i) {
      histogram.Add(truth * ExpSo3(i * 1.5 * kDegree * axis), kSigma, 1.0);
    }
    const OrientationPeak peak = FindPeaks(histogram, {.w_min = 0.5}).front();
    const CellWeights& weights = histogram.weights();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double mass = 0.0;
    for (const CellWeights::Entry& entry : weights.Entries()) {
      if (entry.weight < 0.5F * weights.Largest()) continue;
      const Eigen::AngleAxisd difference(grid.Representative(entry.cell).toRotationMatrix() *
                                         peak.q.toRotationMatrix().transpose());
      const Eigen::Vector3d r = difference.angle() * difference.axis();
      const double share = static_cast<double>(entry.weight) * grid.Area(entry.cell);
      covariance += share * r * r.transpose();
      mass += share;
    }
    covariance /= mass;
    EXPECT_LT((peak.covariance - covariance).norm(), 1e-6 * covariance.norm());
    EXPECT_NEAR(peak.weight, mass / histogram.Mass(), 1e-6);
    EXPECT_NEAR(peak.spread, std::sqrt(covariance.trace()), 1e-6);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(peak.covariance);
    EXPECT_GT(std::abs(solver.eigenvectors().col(2).dot(truth * axis)), std::cos(20.0 * kDegree));
  }
}

TEST(Peaks, ParametersAreChecked) {
  EXPECT_TRUE(PeakParameters().Validate().ok());
  EXPECT_FALSE((PeakParameters{.w_min = 0.95, .w_max = 0.9}).Validate().ok());
  EXPECT_FALSE((PeakParameters{.w_min = 0.0}).Validate().ok());
  EXPECT_FALSE((PeakParameters{.w_max = 1.5}).Validate().ok());
  EXPECT_FALSE((PeakParameters{.w_mode = NAN}).Validate().ok());
}

TEST(WeightedMean, IgnoresTheSideOfTheQuaternions) {
  Rng rng(6);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    const Eigen::Vector3d step = 0.2 * rng.UnitVector();
    const Eigen::Quaterniond minus(-(q * ExpSo3(-step)).coeffs());
    const std::vector<WeightedOrientation> pair = {{q * ExpSo3(step), 1.0}, {minus, 1.0}};
    EXPECT_LT(GeodesicAngle(WeightedMean(pair), q), 1e-9);
  }
}

TEST(WeightedMean, OfASpreadOutSetIsItsEigenvector) {
  // Turns about z by -100, 0 and 100 degrees: the mean is in the middle, whatever the order.
  const auto turn = [](double degrees) {
    return ExpSo3(Eigen::Vector3d(0.0, 0.0, degrees * kDegree));
  };
  const std::vector<WeightedOrientation> set = {
      {turn(-100.0), 1.0}, {turn(100.0), 1.0}, {turn(0.0), 1.0}};
  EXPECT_LT(GeodesicAngle(WeightedMean(set), turn(0.0)), 1e-9);
}

}  // namespace
}  // namespace vantage
