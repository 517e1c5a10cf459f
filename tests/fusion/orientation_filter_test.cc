#include "fusion/orientation_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
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

// What a filter says of itself, for comparing it before and after.
struct State {
  explicit State(const OrientationFilter& filter)
      : q_f(filter.Estimate().ok() ? filter.Estimate()->coeffs() : Eigen::Vector4d::Zero()),
        change(filter.last_change()),
        mass(filter.histogram().Mass()),
        entries(filter.histogram().weights().Entries()) {}
  bool operator==(const State&) const = default;

  Eigen::Vector4d q_f;
  double change;
  double mass;
  std::vector<CellWeights::Entry> entries;
};

std::vector<OrientationView> BadViews() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  return {{Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0), 0.0},
          {Eigen::Quaterniond(NAN, 0.0, 0.0, 0.0), 0.0},
          {Eigen::Quaterniond(0.0, kInfinity, 0.0, 0.0), 0.0},
          {Eigen::Quaterniond(1.5, 0.0, 0.0, 0.0), 0.0},
          {q, -1e-9},
          {q, NAN},
          {q, kInfinity}};
}

// Right detections of differing quality among some that are wrong altogether.
std::vector<OrientationView> MixedViews(const Eigen::Quaterniond& truth, int count, Rng& rng) {
  std::vector<OrientationView> views;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Quaterniond q =
        i % 4 == 3 ? rng.Rotation() : truth * ExpSo3(1.5 * kDegree * error);
    views.push_back({q, rng.Uniform(0.0, 1e-5)});
  }
  return views;
}

Eigen::Quaterniond Fused(const So3Grid& grid,
                         FinalOrientation final_orientation,
                         const std::vector<OrientationView>& views) {
  OrientationFilter filter(grid, {.final_orientation = final_orientation});
  filter.Fuse(views);
  return *filter.Estimate();
}

TEST(OrientationFilter, BadViewsChangeNothing) {
  Rng rng(4);
  const So3Grid grid(16);
  for (const double sigma_motion : {0.0, 0.01}) {
    OrientationFilter filter(grid, {.sigma_motion = sigma_motion});
    for (const OrientationView& bad : BadViews()) EXPECT_FALSE(filter.Add(bad).ok());
    EXPECT_FALSE(filter.Estimate().ok());
    EXPECT_TRUE(filter.histogram().empty());
    for (const OrientationView& view : Views(rng.Rotation(), 5, rng)) {
      ASSERT_TRUE(filter.Add(view).ok());
    }
    const State before(filter);
    for (const OrientationView& bad : BadViews()) {
      const auto added = filter.Add(bad);
      ASSERT_FALSE(added.ok());
      EXPECT_NE(added.error().message.find("expected"), std::string::npos);
    }
    EXPECT_TRUE(State(filter) == before);
    EXPECT_TRUE(filter.converged());
  }
}

TEST(OrientationFilter, WithoutViewsItIsAsNew) {
  Rng rng(11);
  const So3Grid grid(16);
  OrientationFilter filter(grid, {});
  const std::vector<OrientationView> views = Views(rng.Rotation(), 5, rng);
  filter.Fuse(views);
  filter.Fuse({});
  EXPECT_FALSE(filter.Estimate().ok());
  EXPECT_TRUE(filter.peaks().empty());
  EXPECT_TRUE(filter.histogram().empty());
  EXPECT_FALSE(filter.converged());
  filter.Fuse(views);
  OrientationFilter fresh(grid, {});
  fresh.Fuse(views);
  ExpectSame(filter, fresh);
}

TEST(OrientationFilter, ViewsWithoutWeightDoNotConverge) {
  const So3Grid grid(16);
  OrientationFilter filter(grid, {});
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(filter.Add({ExpSo3({1.0, 0.0, 0.0}), 1.0}).ok());
  EXPECT_EQ(filter.last_change(), -1.0);
  EXPECT_FALSE(filter.converged());
  // The only view with weight sees the object as it lies in its own frame.
  ASSERT_TRUE(filter.Add({Eigen::Quaterniond::Identity(), 0.0}).ok());
  EXPECT_EQ(filter.last_change(), -1.0);
  EXPECT_FALSE(filter.converged());
  ASSERT_TRUE(filter.Add({Eigen::Quaterniond::Identity(), 0.0}).ok());
  EXPECT_LT(filter.last_change(), 1e-9);
  EXPECT_FALSE(filter.converged());
  ASSERT_TRUE(filter.Add({Eigen::Quaterniond::Identity(), 0.0}).ok());
  EXPECT_TRUE(filter.converged());
}

TEST(OrientationFilter, TheMassIsTheSumOfTheWeights) {
  Rng rng(5);
  const So3Grid grid(16);
  for (int trial = 0; trial < 10; ++trial) {
    const std::vector<OrientationView> views = MixedViews(rng.Rotation(), 12, rng);
    for (const double sigma_motion : {0.0, 3.0 * kDegree}) {
      OrientationFilterParameters parameters;
      parameters.sigma_motion = sigma_motion;
      double w_v = 0.0;
      for (const OrientationView& view : views) {
        w_v += std::exp(-0.5 * std::pow(view.mse / parameters.sigma_vw, 2));
      }
      for (const auto final_orientation :
           {FinalOrientation::kCwVwClustering, FinalOrientation::kDensityMode}) {
        parameters.final_orientation = final_orientation;
        OrientationFilter filter(grid, parameters);
        filter.Fuse(views);
        EXPECT_NEAR(filter.histogram().Mass(), w_v, 1e-9);
      }
      parameters.final_orientation = FinalOrientation::kCwClustering;
      OrientationFilter unweighted(grid, parameters);
      unweighted.Fuse(views);
      EXPECT_NEAR(unweighted.histogram().Mass(), 12.0, 1e-9);
    }
  }
}

// Turning the world turns q_f: the density's mode exactly, the others as far as the grid's cells
// allow, which do not turn with it.
TEST(OrientationFilter, TurnsWithTheWorld) {
  Rng rng(6);
  const So3Grid grid(32);
  struct Bound {
    FinalOrientation final_orientation;
    double largest_deg;
    double mean_deg;
  };
  for (const Bound& bound : {Bound{FinalOrientation::kVoting, 8.0, 3.5},
                             Bound{FinalOrientation::kVwVoting, 8.0, 3.5},
                             Bound{FinalOrientation::kCwClustering, 2.5, 1.2},
                             Bound{FinalOrientation::kCwVwClustering, 2.5, 1.2},
                             Bound{FinalOrientation::kDensityMode, 1e-4, 1e-5}}) {
    double largest = 0.0;
    double sum = 0.0;
    constexpr int kTrials = 40;
    for (int trial = 0; trial < kTrials; ++trial) {
      const std::vector<OrientationView> views = MixedViews(rng.Rotation(), 16, rng);
      const Eigen::Quaterniond turn = rng.Rotation();
      std::vector<OrientationView> turned = views;
      for (OrientationView& view : turned) view.q_world_object = turn * view.q_world_object;
      const double difference = GeodesicAngle(Fused(grid, bound.final_orientation, turned),
                                              turn * Fused(grid, bound.final_orientation, views)) /
                                kDegree;
      largest = std::max(largest, difference);
      sum += difference;
    }
    EXPECT_LT(largest, bound.largest_deg) << Name(bound.final_orientation);
    EXPECT_LT(sum / kTrials, bound.mean_deg) << Name(bound.final_orientation);
  }
}

TEST(OrientationFilter, IgnoresTheSideAndTheOrderOfTheQuaternions) {
  Rng rng(7);
  const So3Grid grid(16);
  for (int trial = 0; trial < 30; ++trial) {
    Eigen::Quaterniond truth = rng.Rotation();
    if (trial % 2 == 0) truth.w() = 1e-3 * rng.Normal();
    truth.normalize();
    const std::vector<OrientationView> views = MixedViews(truth, 10, rng);
    std::vector<OrientationView> other_side = views;
    for (OrientationView& view : other_side) {
      if (rng.Below(2) == 0) view.q_world_object.coeffs() *= -1.0;
    }
    const std::vector<OrientationView> reversed(views.rbegin(), views.rend());
    for (const FinalOrientation final_orientation : kFinalOrientations) {
      const Eigen::Quaterniond q_f = Fused(grid, final_orientation, views);
      EXPECT_GE(q_f.w(), 0.0);
      EXPECT_EQ(Fused(grid, final_orientation, other_side).coeffs(), q_f.coeffs())
          << Name(final_orientation);
      EXPECT_LT(GeodesicAngle(Fused(grid, final_orientation, reversed), q_f), 1e-6)
          << Name(final_orientation);
    }
  }
}

// Every view sees the bottle turned otherwise about its axis; only the axis is known at all.
TEST(OrientationFilter, ConvergesModuloSymmetry) {
  Rng rng(8);
  const So3Grid grid(16);
  const Eigen::Vector3d axis = Eigen::Vector3d(0.0, 0.6, 0.8);
  for (const bool flips : {false, true}) {
    const SymmetryGroup group = SymmetryGroup::Continuous(axis, flips);
    OrientationFilter told(grid, {}, {.prior = {}, .symmetry = group});
    OrientationFilter untold(grid, {});
    const Eigen::Quaterniond truth = rng.Rotation();
    for (const OrientationView& view : Views(truth, 12, rng)) {
      Eigen::Quaterniond q = view.q_world_object * ExpSo3(rng.Uniform(-3.1, 3.1) * axis);
      if (flips && rng.Below(2) == 0) q = q * ExpSo3(M_PI * axis.unitOrthogonal());
      ASSERT_TRUE(told.Add({q, 1e-6}).ok());
      ASSERT_TRUE(untold.Add({q, 1e-6}).ok());
    }
    EXPECT_TRUE(told.converged());
    EXPECT_LT(told.last_change(), 0.3 * kDegree);
    EXPECT_LT(SymmetricAngle(group, *told.Estimate(), truth), 0.6 * kDegree);
    EXPECT_EQ(told.peaks().size(), 1U);
    EXPECT_GT(untold.peaks().size(), 3U);
  }
}

// The histogram of views between which the robot's pose errors pile up, view by view.
TEST(OrientationFilter, MotionWidensWhatWasSeenBefore) {
  Rng rng(9);
  const So3Grid grid(16);
  const std::vector<OrientationView> views = MixedViews(rng.Rotation(), 6, rng);
  OrientationFilterParameters parameters;
  parameters.sigma_motion = 2.0 * kDegree;
  parameters.final_orientation = FinalOrientation::kCwClustering;
  OrientationFilter filter(grid, parameters);
  for (const OrientationView& view : views) ASSERT_TRUE(filter.Add(view).ok());
  OrientationHistogram expected(grid);
  for (size_t i = 0; i < views.size(); ++i) {
    const auto age = static_cast<double>(views.size() - 1 - i);
    const double variance = std::pow(4.0 * kDegree, 2) + age * std::pow(2.0 * kDegree, 2);
    expected.Add(views[i].q_world_object.normalized(), std::sqrt(variance), 1.0);
  }
  const auto found = filter.histogram().weights().Entries();
  const auto wanted = expected.weights().Entries();
  ASSERT_EQ(found.size(), wanted.size());
  for (size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].cell, wanted[i].cell);
    ASSERT_NEAR(found[i].weight, wanted[i].weight, 1e-5F * wanted[i].weight);
  }
}

TEST(OrientationFilter, AfterMotionTheNewestViewsCountMost) {
  const So3Grid grid(16);
  const Eigen::Quaterniond before = ExpSo3({0.3, -0.8, 1.2});
  const Eigen::Quaterniond after = ExpSo3({3.0 * kDegree, 0.0, 0.0}) * before;
  std::vector<OrientationView> views(4, {before, 1e-6});
  views.resize(8, {after, 1e-6});
  OrientationFilterParameters parameters;
  parameters.mode.bandwidth = 0.0;
  OrientationFilter at_rest(grid, parameters);
  parameters.sigma_motion = 3.0 * kDegree;
  OrientationFilter moving(grid, parameters);
  at_rest.Fuse(views);
  for (const OrientationView& view : views) ASSERT_TRUE(moving.Add(view).ok());
  EXPECT_NEAR(GeodesicAngle(*at_rest.Estimate(), after) / kDegree, 1.5, 1e-4);
  EXPECT_LT(GeodesicAngle(*moving.Estimate(), after) / kDegree, 0.5);
  // Whether the views come one by one or all at once.
  OrientationFilter at_once(grid, parameters);
  at_once.Fuse(views);
  ExpectSame(moving, at_once);
}

TEST(OrientationFilter, AllFinalOrientationsAreThoseOfFiveFilters) {
  Rng rng(10);
  const So3Grid grid(16);
  const std::vector<OrientationView> views = MixedViews(rng.Rotation(), 9, rng);
  const auto all = AllFinalOrientations(grid, {}, views);
  ASSERT_TRUE(all.ok());
  ASSERT_EQ(all->size(), kFinalOrientations.size());
  for (size_t i = 0; i < all->size(); ++i) {
    EXPECT_EQ((*all)[i].coeffs(), Fused(grid, kFinalOrientations[i], views).coeffs()) << i;
    EXPECT_EQ(FinalOrientationFromName(Name(kFinalOrientations[i])), kFinalOrientations[i]);
  }
  EXPECT_FALSE(FinalOrientationFromName("mean").has_value());
  EXPECT_FALSE(AllFinalOrientations(grid, {}, {}).ok());
  for (const OrientationView& bad : BadViews()) {
    std::vector<OrientationView> with_bad = views;
    with_bad.insert(with_bad.begin() + 4, bad);
    EXPECT_FALSE(AllFinalOrientations(grid, {}, with_bad).ok());
  }
  // A view so bad that its verification weight is 0 leaves nothing to the ways that use it.
  const std::vector<OrientationView> weightless(3, {views.front().q_world_object, 1.0});
  EXPECT_FALSE(AllFinalOrientations(grid, {}, weightless).ok());
}

TEST(OrientationFilter, ParametersAreChecked) {
  EXPECT_TRUE(OrientationFilterParameters().Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.sigma_cw = 0.0}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.sigma_vw = -1.0}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.peaks = {.w_min = 2.0}}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.sigma_motion = -0.1}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.sigma_motion = NAN}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.mode = {.sigma = 0.0}}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.converge_angle = NAN}).Validate().ok());
  EXPECT_FALSE((OrientationFilterParameters{.min_views = 0}).Validate().ok());
}

// Detections strung out along a turn, as of a mug whose handle is hidden: no place among them has
// as many as the right one, but a low wide region has more mass than a high narrow one.
TEST(OrientationFilter, AWideRegionDoesNotOutweighTheHighestMode) {
  const So3Grid grid(32);
  Rng rng(31);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const Eigen::Vector3d axis = rng.UnitVector();
    OrientationFilter filter(grid, {});
    for (const double turn_deg : {0.2, 35.0, 41.0, -0.2, 47.0, 53.0, 0.1, 59.0, 65.0}) {
      const Eigen::Quaterniond q = truth * ExpSo3(turn_deg * kDegree * axis);
      ASSERT_TRUE(filter.Add({q, 5e-7}).ok());
    }
    ASSERT_GT(filter.peaks().size(), 1U);
    EXPECT_LT(GeodesicAngle(filter.Estimate().value(), truth), 0.5 * kDegree) << trial;
  }
}

}  // namespace
}  // namespace vantage
