#include "fusion/compared/knn_clustering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

// Sizes of the components of the graph that joins orientations within `distance`, largest first:
// every pair, until nothing changes.
std::vector<int64_t> ComponentSizes(const std::vector<Eigen::Quaterniond>& views, double distance) {
  std::vector<size_t> labels(views.size());
  for (size_t i = 0; i < views.size(); ++i) labels[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t i = 0; i < views.size(); ++i) {
      for (size_t j = 0; j < views.size(); ++j) {
        if (GeodesicAngle(views[i], views[j]) > distance || labels[i] <= labels[j]) continue;
        labels[i] = labels[j];
        changed = true;
      }
    }
  }
  std::vector<int64_t> sizes;
  for (size_t label = 0; label < views.size(); ++label) {
    const auto size = std::count(labels.begin(), labels.end(), label);
    if (size > 0) sizes.push_back(size);
  }
  std::sort(sizes.rbegin(), sizes.rend());
  return sizes;
}

Eigen::Quaterniond Noisy(const Eigen::Quaterniond& q, double sigma, Rng& rng) {
  return q * ExpSo3(sigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
}

TEST(KnnClustering, ClustersAreTheComponentsWhateverTheOrder) {
  Rng rng(1);
  for (const double distance : {5.0 * kDegree, 25.0 * kDegree, 40.0 * kDegree}) {
    std::vector<Eigen::Quaterniond> views;
    for (int i = 0; i < 120; ++i) views.push_back(rng.Rotation());
    for (int i = 0; i < 20; ++i) views.push_back(Noisy(views[3], 3.0 * kDegree, rng));
    views.push_back(views[5]);
    views.push_back(Eigen::Quaterniond(-views[5].coeffs()));
    const std::vector<int64_t> expected = ComponentSizes(views, distance);
    std::vector<Eigen::Quaterniond> estimates;
    for (int order = 0; order < 3; ++order) {
      for (size_t i = views.size() - 1; order > 0 && i > 0; --i) {
        std::swap(views[i], views[rng.Below(static_cast<uint32_t>(i + 1))]);
      }
      KnnClustering clustering({.max_distance = distance});
      for (const Eigen::Quaterniond& q : views) ASSERT_TRUE(clustering.Add({q, 0.0}).ok());
      std::vector<int64_t> sizes = clustering.ClusterSizes();
      std::sort(sizes.rbegin(), sizes.rend());
      EXPECT_EQ(sizes, expected);
      EXPECT_EQ(clustering.num_orientations(), 140U);
      estimates.push_back(clustering.Estimate().value());
      EXPECT_LT(GeodesicAngle(estimates.front(), estimates.back()), 1e-9);
    }
  }
}

TEST(KnnClustering, LargestClusterIsAveragedAndTheRestLeftOut) {
  Rng rng(2);
  const Eigen::Quaterniond truth = rng.Rotation();
  KnnClustering clustering;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d error =
        1.0 * kDegree * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
    sum += error;
    ASSERT_TRUE(clustering.Add({truth * ExpSo3(error), 0.0}).ok());
  }
  const Eigen::Quaterniond flipped = truth * ExpSo3(std::numbers::pi * Eigen::Vector3d::UnitZ());
  for (int i = 0; i < 19; ++i) {
    ASSERT_TRUE(clustering.Add({Noisy(flipped, kDegree, rng), 0.0}).ok());
  }
  // Small errors average like vectors.
  const Eigen::Quaterniond estimate = clustering.Estimate().value();
  EXPECT_LT(GeodesicAngle(estimate, truth * ExpSo3(sum / 20.0)), 0.01 * kDegree);
  EXPECT_EQ(estimate.coeffs(), Canonical(estimate).coeffs());
}

TEST(KnnClustering, OfEquallyLargeClustersTheCloserOneThenTheEarlier) {
  const auto about_x = [](double deg) { return ExpSo3({deg * kDegree, 0.0, 0.0}); };
  KnnClustering clustering;
  EXPECT_FALSE(clustering.Estimate().ok());
  ASSERT_TRUE(clustering.Add({about_x(0.0), 0.0}).ok());
  ASSERT_TRUE(clustering.Add({about_x(90.0), 0.0}).ok());
  EXPECT_LT(GeodesicAngle(clustering.Estimate().value(), about_x(0.0)), 1e-12);
  ASSERT_TRUE(clustering.Add({about_x(8.0), 0.0}).ok());
  ASSERT_TRUE(clustering.Add({about_x(92.0), 0.0}).ok());
  EXPECT_LT(GeodesicAngle(clustering.Estimate().value(), about_x(91.0)), 1e-9);
}

TEST(KnnClustering, ANeighborOfTwoClustersJoinsThem) {
  const auto about_x = [](double deg) { return ExpSo3({deg * kDegree, 0.0, 0.0}); };
  KnnClustering clustering;
  for (const double deg : {0.0, 16.0, 100.0}) {
    ASSERT_TRUE(clustering.Add({about_x(deg), 0.0}).ok());
  }
  EXPECT_EQ(clustering.ClusterSizes(), (std::vector<int64_t>{1, 1, 1}));
  ASSERT_TRUE(clustering.Add({about_x(8.0), 0.0}).ok());
  EXPECT_EQ(clustering.ClusterSizes(), (std::vector<int64_t>{3, 1}));
  EXPECT_LT(GeodesicAngle(clustering.Estimate().value(), about_x(8.0)), 1e-9);
  // Just in and just out of reach.
  ASSERT_TRUE(clustering.Add({about_x(25.9999), 0.0}).ok());
  ASSERT_TRUE(clustering.Add({about_x(89.9999), 0.0}).ok());
  EXPECT_EQ(clustering.ClusterSizes(), (std::vector<int64_t>{4, 1, 1}));
}

TEST(KnnClustering, AMillionEqualDetectionsAreKeptOnce) {
  Rng rng(3);
  const Eigen::Quaterniond q = rng.Rotation();
  const Eigen::Quaterniond minus(-q.coeffs());
  KnnClustering clustering;
  for (int i = 0; i < 1000000; ++i) ASSERT_TRUE(clustering.Add({i % 2 == 0 ? q : minus, 0.0}).ok());
  EXPECT_EQ(clustering.num_orientations(), 1U);
  EXPECT_EQ(clustering.ClusterSizes(), std::vector<int64_t>{1000000});
  EXPECT_LT(GeodesicAngle(clustering.Estimate().value(), q), 1e-9);
}

TEST(KnnClustering, BadViewsChangeNothingAndParametersAreChecked) {
  Rng rng(4);
  KnnClustering clustering;
  const Eigen::Quaterniond q = rng.Rotation();
  ASSERT_TRUE(clustering.Add({Eigen::Quaterniond(0.9995 * q.coeffs()), 0.0}).ok());
  EXPECT_LT(GeodesicAngle(clustering.Estimate().value(), q), 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(clustering.Add({Eigen::Quaterniond(2.0 * q.coeffs()), 0.0}).ok());
  EXPECT_FALSE(clustering.Add({q, nan}).ok());
  EXPECT_FALSE(clustering.Add({Eigen::Quaterniond(nan, nan, nan, nan), 0.0}).ok());
  EXPECT_EQ(clustering.ClusterSizes(), std::vector<int64_t>{1});

  EXPECT_TRUE(KnnClusteringParameters{}.Validate().ok());
  for (const double distance : {0.0, -1.0, 3.2, nan}) {
    EXPECT_FALSE(KnnClusteringParameters{.max_distance = distance}.Validate().ok());
  }
}

}  // namespace
}  // namespace vantage
