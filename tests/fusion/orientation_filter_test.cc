#include "fusion/orientation_filter.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

std::vector<OrientationView> Views(const Eigen::Quaterniond& truth, int count, Rng& rng) {
  std::vector<OrientationView> views;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    views.push_back({truth * ExpSo3(0.5 * kDegree * error), 1e-6});
  }
  return views;
}

void ExpectSame(const OrientationFilter& a, const OrientationFilter& b) {
  ASSERT_EQ(a.peaks().size(), b.peaks().size());
  for (size_t i = 0; i < a.peaks().size(); ++i) {
    EXPECT_EQ(a.peaks()[i].q.coeffs(), b.peaks()[i].q.coeffs()) << i;
    EXPECT_EQ(a.peaks()[i].weight, b.peaks()[i].weight) << i;
  }
  EXPECT_EQ(a.last_change(), b.last_change());
  EXPECT_EQ(a.converged(), b.converged());
  ASSERT_EQ(a.histogram().weights().Entries(), b.histogram().weights().Entries());
}

TEST(OrientationFilter, FusingStepByStepEqualsFusingAtOnce) {
  Rng rng(1);
  const So3Grid grid(32);
  std::vector<OrientationView> views = Views(rng.Rotation(), 7, rng);
  OrientationFilter stepwise(grid, {});
  for (size_t i = 1; i <= views.size(); ++i) {
    stepwise.Fuse({views.begin(), views.begin() + static_cast<std::ptrdiff_t>(i)});
  }
  OrientationFilter at_once(grid, {});
  at_once.Fuse(views);
  ExpectSame(stepwise, at_once);

  // A view in the middle replaced, then the last ones taken away.
  views[3].q_world_object = rng.Rotation();
  stepwise.Fuse(views);
  OrientationFilter replaced(grid, {});
  replaced.Fuse(views);
  ExpectSame(stepwise, replaced);
  views.resize(4);
  stepwise.Fuse(views);
  OrientationFilter shorter(grid, {});
  shorter.Fuse(views);
  ExpectSame(stepwise, shorter);
}

TEST(OrientationFilter, ConvergesOnceQfStaysAndEnoughViewsWereTaken) {
  Rng rng(2);
  const So3Grid grid(32);
  std::vector<OrientationView> views = Views(rng.Rotation(), 1, rng);
  views.resize(6, views.front());  // The same orientation: q_f can't move.
  OrientationFilter filter(grid, {});
  for (size_t i = 1; i <= 6; ++i) {
    filter.Fuse({views.begin(), views.begin() + static_cast<std::ptrdiff_t>(i)});
    EXPECT_EQ(filter.converged(), i >= 4) << i;
  }
  EXPECT_LT(filter.last_change(), 1e-9);
  const Eigen::Quaterniond before = filter.peaks().front().q;

  // Heavy news from elsewhere undo it.
  for (int i = 0; i < 8; ++i) views.push_back({views.front().q_world_object.conjugate(), 0.0});
  filter.Fuse(views);
  EXPECT_FALSE(filter.converged() && filter.last_change() > 1.0 * kDegree);
  EXPECT_GT(GeodesicAngle(before, filter.peaks().front().q), 0.1);
}

TEST(OrientationFilter, ABadFitCountsLittle) {
  Rng rng(3);
  const So3Grid grid(32);
  const Eigen::Quaterniond good = rng.Rotation();
  const Eigen::Quaterniond bad = good * ExpSo3(Eigen::Vector3d(1.0, 0.0, 0.0));
  OrientationFilter filter(grid, {});
  filter.Fuse({{bad, 2e-5}, {bad, 2e-5}, {bad, 2e-5}, {good, 1e-6}});
  EXPECT_LT(GeodesicAngle(filter.peaks().front().q, good), 2.0 * kDegree);
}

TEST(OrientationFilter, WithoutAnyWeightThereIsNoPeak) {
  const So3Grid grid(16);
  OrientationFilter filter(grid, {});
  filter.Fuse({{Eigen::Quaterniond::Identity(), 1.0}});
  EXPECT_TRUE(filter.peaks().empty());
  EXPECT_FALSE(filter.converged());
  EXPECT_EQ(filter.last_change(), -1.0);
}

TEST(OrientationFilter, ParametersAreChecked) {
  EXPECT_TRUE(OrientationFilterParameters().Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.sigma_cw = 0.0}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.sigma_vw = -1.0}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.peaks = {.w_min = 2.0}}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.min_views = 0}).Validate().ok());
}

}  // namespace
}  // namespace vantage
