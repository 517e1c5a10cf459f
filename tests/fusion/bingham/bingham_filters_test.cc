#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "common/statistics.h"
#include "fusion/bingham/bingham_mixture_filter.h"
#include "fusion/bingham/bingham_smc_filter.h"

namespace vantage {
namespace {

constexpr double kSigma = 4.0 * kDegree;

Eigen::Quaterniond Near(const Eigen::Quaterniond& q, Rng& rng) {
  return q * ExpSo3(kSigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
}

std::vector<OrientationView> Views(const Eigen::Quaterniond& truth,
                                   int count,
                                   double outliers,
                                   Rng& rng) {
  std::vector<OrientationView> views;
  for (int i = 0; i < count; ++i) {
    views.push_back({rng.Uniform() < outliers ? rng.Rotation() : Near(truth, rng), 1e-6});
  }
  return views;
}

Eigen::Quaterniond Fused(OrientationFusion& filter, const std::vector<OrientationView>& views) {
  for (const OrientationView& view : views) EXPECT_TRUE(filter.Add(view).ok());
  return filter.Estimate().value();
}

struct Method {
  const char* name;
  std::function<std::unique_ptr<OrientationFusion>()> make;
};

class BinghamFilters : public testing::TestWithParam<Method> {};

TEST_P(BinghamFilters, FindTheTruthAmongOutliers) {
  Rng rng(1);
  std::vector<double> errors;
  for (int i = 0; i < 15; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const std::unique_ptr<OrientationFusion> filter = GetParam().make();
    errors.push_back(GeodesicAngle(Fused(*filter, Views(truth, 30, 0.2, rng)), truth));
  }
  // 24 views leave 4 / sqrt(24) = 0.8 degrees about each axis, 1.3 in all.
  EXPECT_LT(Median(errors), 1.8 * kDegree);
  EXPECT_LT(Quantile(errors, 1.0), 4.0 * kDegree);
}

TEST_P(BinghamFilters, OneViewIsTheEstimate) {
  Rng rng(2);
  const OrientationView view{rng.Rotation(), 1e-6};
  const std::unique_ptr<OrientationFusion> filter = GetParam().make();
  EXPECT_LT(GeodesicAngle(Fused(*filter, {view}), view.q_world_object), 0.1 * kDegree);
  EXPECT_GE(filter->Estimate()->w(), 0.0);
}

TEST_P(BinghamFilters, LeaveAWrongFirstView) {
  Rng rng(3);
  for (int i = 0; i < 5; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    std::vector<OrientationView> views = Views(truth, 8, 0.0, rng);
    views.front().q_world_object = rng.Rotation();
    const std::unique_ptr<OrientationFusion> filter = GetParam().make();
    EXPECT_LT(GeodesicAngle(Fused(*filter, views), truth), 8.0 * kDegree);
  }
}

TEST_P(BinghamFilters, TakeNegatedAndNearlyNormalizedQuaternionsAlike) {
  Rng rng(4);
  const std::vector<OrientationView> views = Views(rng.Rotation(), 6, 0.2, rng);
  std::vector<OrientationView> changed = views;
  for (size_t i = 0; i < changed.size(); ++i) {
    changed[i].q_world_object.coeffs() *= i % 2 == 0 ? -1.0 : 1.0009;
  }
  const std::unique_ptr<OrientationFusion> a = GetParam().make();
  const std::unique_ptr<OrientationFusion> b = GetParam().make();
  // The samples are floats, and signs may turn where they are rounded.
  EXPECT_LT(GeodesicAngle(Fused(*a, views), Fused(*b, changed)), 0.1 * kDegree);
}

TEST_P(BinghamFilters, BadViewsChangeNothing) {
  Rng rng(5);
  const std::unique_ptr<OrientationFusion> filter = GetParam().make();
  const std::unique_ptr<OrientationFusion> same = GetParam().make();
  EXPECT_FALSE(filter->Estimate().ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<OrientationView> bad = {{Eigen::Quaterniond(nan, 0.0, 0.0, 0.0), 0.0},
                                            {Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), 0.0},
                                            {Eigen::Quaterniond(1.1, 0.0, 0.0, 0.0), 0.0},
                                            {Eigen::Quaterniond::Identity(), -1.0},
                                            {Eigen::Quaterniond::Identity(), nan}};
  for (const OrientationView& view : bad) EXPECT_FALSE(filter->Add(view).ok());
  EXPECT_FALSE(filter->Estimate().ok());
  for (const OrientationView& view : Views(rng.Rotation(), 5, 0.2, rng)) {
    EXPECT_TRUE(filter->Add(view).ok());
    EXPECT_TRUE(same->Add(view).ok());
    for (const OrientationView& wrong : bad) EXPECT_FALSE(filter->Add(wrong).ok());
  }
  EXPECT_EQ(filter->Estimate()->coeffs(), same->Estimate()->coeffs());
}

TEST_P(BinghamFilters, IdenticalViewsStaySafe) {
  Rng rng(6);
  const OrientationView view{rng.Rotation(), 1e-6};
  const std::unique_ptr<OrientationFusion> filter = GetParam().make();
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(filter->Add(view).ok());
  EXPECT_LT(GeodesicAngle(*filter->Estimate(), view.q_world_object), 0.05 * kDegree);
}

INSTANTIATE_TEST_SUITE_P(Both,
                         BinghamFilters,
                         testing::Values(Method{"MR",
                                                [] {
                                                  return std::make_unique<BinghamMixtureFilter>(
                                                      BinghamMixtureParameters{});
                                                }},
                                         Method{"SMC",
                                                [] {
                                                  return std::make_unique<BinghamSmcFilter>(
                                                      BinghamSmcParameters{.num_samples = 20'000},
                                                      42);
                                                }}),
                         [](const auto& tested) { return std::string(tested.param.name); });

/// Bayes' rule without any reduction, evaluated on a dense cloud of orientations.
TEST(BinghamMixtureFilter, StateIsThePosteriorWhileNothingIsReduced) {
  Rng rng(7);
  const double sigma = 15.0 * kDegree;
  BinghamMixtureFilter filter({.sigma = sigma, .peaked_weight = 0.9, .max_components = 1000});
  std::vector<BinghamMixture> likelihoods;
  const Eigen::Quaterniond truth = rng.Rotation();
  for (const OrientationView& view : Views(truth, 6, 0.3, rng)) {
    ASSERT_TRUE(filter.Add(view).ok());
    likelihoods.push_back(
        BinghamMixture({{std::log(0.9), BinghamDistribution::Isotropic(view.q_world_object, sigma)},
                        {std::log(0.1), BinghamDistribution()}}));
  }
  EXPECT_EQ(filter.state().components().size(), 64U);
  const auto log_posterior = [&likelihoods](const Eigen::Quaterniond& q) {
    double sum = 0.0;
    for (const BinghamMixture& likelihood : likelihoods) sum += likelihood.LogDensity(q);
    return sum;
  };
  const double offset = log_posterior(truth) - filter.state().LogDensity(truth);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    EXPECT_NEAR(log_posterior(q) - filter.state().LogDensity(q), offset, 1e-8);
    EXPECT_LE(log_posterior(q), log_posterior(*filter.Estimate()) + 1e-9);
  }
}

TEST(BinghamMixtureFilter, TurnsWithItsViews) {
  Rng rng(8);
  for (int i = 0; i < 5; ++i) {
    const std::vector<OrientationView> views = Views(rng.Rotation(), 30, 0.3, rng);
    const Eigen::Quaterniond left = rng.Rotation();
    const Eigen::Quaterniond right = rng.Rotation();
    std::vector<OrientationView> turned = views;
    for (OrientationView& view : turned) view.q_world_object = left * view.q_world_object * right;
    BinghamMixtureFilter filter({.max_components = 8});
    BinghamMixtureFilter turned_filter({.max_components = 8});
    EXPECT_LT(GeodesicAngle(left * Fused(filter, views) * right, Fused(turned_filter, turned)),
              1e-6);
  }
}

TEST(BinghamMixtureFilter, ASecondOrientationThatComesLateStillWins) {
  Rng rng(9);
  const Eigen::Quaterniond truth = rng.Rotation();
  const Eigen::Quaterniond alias = truth * ExpSo3(Eigen::Vector3d(0.0, 0.0, 2.0));
  std::vector<OrientationView> views = Views(alias, 5, 0.0, rng);
  const std::vector<OrientationView> later = Views(truth, 20, 0.2, rng);
  views.insert(views.end(), later.begin(), later.end());
  BinghamMixtureFilter filter({});
  EXPECT_LT(GeodesicAngle(Fused(filter, views), truth), 5.0 * kDegree);
}

TEST(BinghamMixtureFilter, TenThousandUpdatesStayBoundedAndFinite) {
  Rng rng(10);
  const Eigen::Quaterniond truth = rng.Rotation();
  BinghamMixtureFilter filter({.max_components = 6});
  for (const OrientationView& view : Views(truth, 10'000, 0.2, rng)) {
    ASSERT_TRUE(filter.Add(view).ok());
    ASSERT_LE(filter.state().components().size(), 7U);
  }
  for (const BinghamComponent& component : filter.state().components()) {
    EXPECT_TRUE(std::isfinite(component.log_weight));
    EXPECT_TRUE(component.distribution.matrix().allFinite());
  }
  EXPECT_LT(GeodesicAngle(*filter.Estimate(), truth), 0.5 * kDegree);
}

TEST(BinghamSmcFilter, SeedsGiveTheSameAgain) {
  Rng rng(11);
  const std::vector<OrientationView> views = Views(rng.Rotation(), 10, 0.2, rng);
  BinghamSmcFilter a({.num_samples = 5'000}, 1);
  BinghamSmcFilter b({.num_samples = 5'000}, 1);
  BinghamSmcFilter c({.num_samples = 5'000}, 2);
  const Eigen::Quaterniond first = Fused(a, views);
  EXPECT_EQ(first.coeffs(), Fused(b, views).coeffs());
  EXPECT_NE(first.coeffs(), Fused(c, views).coeffs());
}

/// But for jitter it samples the posterior, which the other filter has in closed form.
TEST(BinghamSmcFilter, AgreesWithTheExactPosterior) {
  Rng rng(12);
  for (int i = 0; i < 3; ++i) {
    const std::vector<OrientationView> views = Views(rng.Rotation(), 10, 0.2, rng);
    BinghamSmcFilter samples({.peaked_weight = 0.9}, 3);
    BinghamMixtureFilter exact({.peaked_weight = 0.9, .max_components = 1000});
    EXPECT_LT(GeodesicAngle(Fused(samples, views), Fused(exact, views)), 0.5 * kDegree);
  }
}

TEST(BinghamParameters, AreChecked) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(BinghamMixtureParameters().Validate().ok());
  EXPECT_FALSE((BinghamMixtureParameters{.sigma = 0.0}).Validate().ok());
  EXPECT_FALSE((BinghamMixtureParameters{.sigma = nan}).Validate().ok());
  EXPECT_FALSE((BinghamMixtureParameters{.peaked_weight = 1.0}).Validate().ok());
  EXPECT_FALSE((BinghamMixtureParameters{.max_components = 0}).Validate().ok());
  EXPECT_TRUE(BinghamSmcParameters().Validate().ok());
  EXPECT_FALSE((BinghamSmcParameters{.sigma = 0.001}).Validate().ok());
  EXPECT_FALSE((BinghamSmcParameters{.sigma = nan}).Validate().ok());
  EXPECT_FALSE((BinghamSmcParameters{.peaked_weight = 0.0}).Validate().ok());
  EXPECT_FALSE((BinghamSmcParameters{.num_samples = 0}).Validate().ok());
  EXPECT_FALSE((BinghamSmcParameters{.jitter = -0.1}).Validate().ok());
}

}  // namespace
}  // namespace vantage
