#include "fusion/confusion/mode_belief.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "tests/fusion/confusion/synthetic_object.h"

namespace vantage {
namespace {

ConfusionModel Made(const ContingencyTable& table,
                    const SymmetryGroup& symmetry = SymmetryGroup::None(),
                    const ConfusionModelParameters& parameters = {}) {
  Result<ConfusionModel> model = ConfusionModel::Make(table, symmetry, parameters);
  EXPECT_TRUE(model.ok()) << model.error().message;
  return std::move(model).value();
}

ConfusionView Look(const SyntheticObject& object,
                   const Eigen::Quaterniond& q_world_camera,
                   const Eigen::Quaterniond& truth,
                   Rng& rng) {
  ConfusionView view;
  view.q_world_camera = q_world_camera;
  const auto detected = object.Detect(q_world_camera.conjugate() * truth, rng);
  if (detected) view.q_world_object = q_world_camera * *detected;
  return view;
}

std::vector<ConfusionView> Looks(const SyntheticObject& object,
                                 const Eigen::Quaterniond& truth,
                                 int count,
                                 Rng& rng) {
  std::vector<ConfusionView> views;
  for (int i = 0; i < count; ++i) views.push_back(Look(object, rng.Rotation(), truth, rng));
  return views;
}

double ProbabilityNear(const std::vector<OrientationHypothesis>& belief,
                       const Eigen::Quaterniond& q,
                       double radius) {
  double sum = 0.0;
  for (const OrientationHypothesis& one : belief) {
    if (GeodesicAngle(one.q_world_object, q) <= radius) sum += one.probability;
  }
  return sum;
}

// Bayes over a lattice of rotation vectors about each turn of the truth; elsewhere the views don't
// point to.
std::vector<double> BruteForce(const ConfusionModel& model,
                               const std::vector<ConfusionView>& views,
                               const SyntheticObject& object,
                               const Eigen::Quaterniond& truth) {
  const double sigma = 0.5 * model.parameters().mode_radius;
  const double height = 8.0 * std::pow(std::numbers::pi, 2) /
                        (std::pow(2.0 * std::numbers::pi, 1.5) * std::pow(sigma, 3));
  constexpr int kSteps = 10;
  constexpr int kSide = 2 * kSteps + 1;
  const double step = 4.5 * sigma / kSteps;
  std::vector<double> posterior;
  for (int turn = 0; turn < object.order; ++turn) {
    posterior.push_back(0.0);
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      const Eigen::Vector3i place(i % kSide, i / kSide % kSide, i / (kSide * kSide));
      const Eigen::Vector3d r = step * (place.array() - kSteps).matrix().cast<double>();
      if (r.norm() > kSteps * step) continue;
      const Eigen::Quaterniond q = truth * object.Turn(turn) * ExpSo3(r);
      double probability = 1.0;
      for (const ConfusionView& view : views) {
        const int direction = model.DirectionOf(view.q_world_camera.conjugate() * q);
        double likelihood = model.WithOutliers(model.Scattered(direction));
        for (int mode = 0; mode < model.num_modes(); ++mode) {
          const double angle = GeodesicAngle(q * model.Difference(mode), *view.q_world_object);
          likelihood += model.WithOutliers(model.ShareFrom(direction, mode)) * height *
                        std::exp(-0.5 * angle * angle / (sigma * sigma));
        }
        probability *= likelihood;
      }
      posterior.back() += probability;
    }
  }
  double sum = 0.0;
  for (const double one : posterior) sum += one;
  for (double& one : posterior) one /= sum;
  return posterior;
}

class ModeBeliefOfOrder : public ::testing::TestWithParam<int> {};

TEST_P(ModeBeliefOfOrder, AgreesWithBayesOnAFineLattice) {
  SyntheticObject object;
  object.order = GetParam();
  object.error = 0.3 * kDegree;
  ConfusionModelParameters parameters;
  parameters.mode_radius = 2.0 * kDegree;
  // Shares change little within a hypothesis, which stands for all orientations about it.
  parameters.direction_smoothing = 20.0 * kDegree;
  const ConfusionModel model =
      Made(object.Measure(6250, 20, 11), SymmetryGroup::None(), parameters);
  Rng rng(static_cast<uint64_t>(object.order));
  double squares = 0.0;
  for (int run = 0; run < 20; ++run) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const std::vector<ConfusionView> views = Looks(object, truth, 2 + run % 4, rng);
    const std::vector<OrientationHypothesis> belief = ModeBelief(model, views);
    const std::vector<double> expected = BruteForce(model, views, object, truth);
    for (int turn = 0; turn < object.order; ++turn) {
      const double difference = ProbabilityNear(belief, truth * object.Turn(turn), 5.0 * kDegree) -
                                expected[static_cast<size_t>(turn)];
      // The border between two cells of directions can run through what a hypothesis stands for.
      EXPECT_NEAR(difference, 0.0, 0.03) << "run " << run << ", turn " << turn;
      squares += difference * difference;
    }
  }
  EXPECT_LT(std::sqrt(squares / (20 * object.order)), 0.006);
}

INSTANTIATE_TEST_SUITE_P(Turns, ModeBeliefOfOrder, ::testing::Values(2, 4));

TEST(ModeBelief, IsRightAsOftenAsItSays) {
  SyntheticObject object;
  object.error = 1.0 * kDegree;
  object.outliers = 0.02;
  object.missed = 0.05;
  const ConfusionModel model = Made(object.Measure(1000, 100, 12));
  Rng rng(13);
  struct Bin {
    double claimed = 0.0, variance = 0.0;
    int right = 0, count = 0;
  };
  std::vector<Bin> bins(4);  // By claim: to 0.4, to 0.75, to 0.95, above.
  for (int run = 0; run < 3000; ++run) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const auto belief = ModeBelief(model, Looks(object, truth, 1 + run % 5, rng));
    if (belief.empty()) continue;  // Nothing detected.
    const double claim = belief.front().probability;
    Bin& bin = bins[claim < 0.4 ? 0 : claim < 0.75 ? 1 : claim < 0.95 ? 2 : 3];
    bin.claimed += claim;
    bin.variance += claim * (1.0 - claim);
    ++bin.count;
    if (GeodesicAngle(belief.front().q_world_object, truth) < 6.0 * kDegree) ++bin.right;
  }
  for (const Bin& bin : bins) {
    ASSERT_GT(bin.count, 50);
    const double claimed = bin.claimed / bin.count;
    const double right = static_cast<double>(bin.right) / bin.count;
    EXPECT_NEAR(right, claimed, 0.02 + 3.0 * std::sqrt(bin.variance) / bin.count);
  }
  EXPECT_GT(static_cast<double>(bins[3].right) / bins[3].count, 0.95);
}

TEST(ModeBelief, OneViewOfTheFeaturelessSideLeavesAllTurns) {
  const SyntheticObject object;
  const ConfusionModel model = Made(object.Measure(391, 200, 14));
  Rng rng(15);
  const Eigen::Quaterniond q_camera_object = OrientationSeenFrom(-Eigen::Vector3d::UnitX(), 0.3);
  // From above: the feature's cap does not reach there for any turn.
  const Eigen::Quaterniond from_above = OrientationSeenFrom(Eigen::Vector3d::UnitZ(), 0.3);
  for (const Eigen::Quaterniond& truth : {from_above}) {
    const auto belief =
        ModeBelief(model, {Look(object, Eigen::Quaterniond::Identity(), truth, rng)});
    ASSERT_EQ(belief.size(), 4U);
    for (const auto& one : belief) EXPECT_NEAR(one.probability, 0.25, 0.05);
    EXPECT_NEAR(BeliefEntropy(belief), std::log(4.0), 0.03);
  }
  // From behind the turn by half is excluded: its feature would be seen.
  const Eigen::Quaterniond detected = q_camera_object * object.Turn(2);
  ConfusionView view;
  view.q_world_object = detected;
  const auto belief = ModeBelief(model, {view});
  EXPECT_LT(ProbabilityNear(belief, detected, 3.0 * kDegree), 0.9);
}

TEST(ModeBelief, DoesNotDependOnTheWorldsFrameNorOnTheOrder) {
  const SyntheticObject object;
  const ConfusionModel model = Made(object.Measure(391, 60, 16));
  Rng rng(17);
  const Eigen::Quaterniond truth = rng.Rotation();
  std::vector<ConfusionView> views = Looks(object, truth, 4, rng);
  const auto belief = ModeBelief(model, views);
  const Eigen::Quaterniond turn = rng.Rotation();
  std::reverse(views.begin(), views.end());
  for (ConfusionView& view : views) {
    view.q_world_camera = turn * view.q_world_camera;
    if (view.q_world_object) view.q_world_object = turn * *view.q_world_object;
  }
  const auto turned = ModeBelief(model, views);
  for (const OrientationHypothesis& one : belief) {
    EXPECT_NEAR(
        ProbabilityNear(turned, turn * one.q_world_object, 3.0 * kDegree), one.probability, 1e-3);
  }
}

TEST(ModeBelief, ThirtyContradictingViewsDoNotUnderflow) {
  const SyntheticObject object;
  const ConfusionModel model = Made(object.Measure(391, 60, 18));
  Rng rng(19);
  std::vector<ConfusionView> views;
  for (int i = 0; i < 30; ++i) {
    ConfusionView view;
    view.q_world_camera = rng.Rotation();
    view.q_world_object = rng.Rotation();
    views.push_back(view);
  }
  for (int repeat = 0; repeat < 2; ++repeat) {
    const auto belief = ModeBelief(model, views);
    ASSERT_FALSE(belief.empty());
    double sum = 0.0;
    for (size_t i = 0; i < belief.size(); ++i) {
      ASSERT_TRUE(std::isfinite(belief[i].probability));
      EXPECT_GE(belief[i].probability, 1e-6);
      EXPECT_LE(belief[i].probability, belief[i - std::min<size_t>(i, 1)].probability);
      sum += belief[i].probability;
    }
    EXPECT_NEAR(sum, 1.0, 1e-9);
    for (int i = 0; i < 30; ++i) views.push_back(views[static_cast<size_t>(i)]);
  }
}

TEST(ModeBelief, OrientationsThatTheSymmetryMakesEqualAreOne) {
  const SyntheticObject object;
  const ContingencyTable table = object.Measure(391, 60, 20);
  const ConfusionModel model = Made(table, SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ()));
  ConfusionView view;
  view.q_world_object = OrientationSeenFrom(Eigen::Vector3d::UnitZ(), 0.1);
  EXPECT_EQ(ModeBelief(model, {view}).size(), 2U);
  ConfusionView equal = view;
  equal.q_world_object = *view.q_world_object * object.Turn(2);
  EXPECT_EQ(ModeBelief(model, {view, equal}).size(), 2U);
  const ConfusionModel all = Made(table, SymmetryGroup::Cyclic(4, Eigen::Vector3d::UnitZ()));
  const auto belief = ModeBelief(all, {view, equal});
  ASSERT_EQ(belief.size(), 1U);
  EXPECT_EQ(belief.front().probability, 1.0);
  EXPECT_EQ(BeliefEntropy(belief), 0.0);
}

// An object that can't be found from where its feature is seen: not to find it tells the turn.
TEST(ModeBelief, LooksThatFindNothingCount) {
  SyntheticObject object;
  object.visible_share = 0.25;
  ContingencyTable table = object.Measure(391, 100, 21);
  const DirectionGrid grid(391);
  for (int i = 0; i < 391; ++i) {
    if (!object.IsVisible(grid.Center(i))) continue;
    DirectionTrials nothing;
    nothing.trials = nothing.missed = 100;
    table.directions[static_cast<size_t>(i)] = nothing;
  }
  const ConfusionModel model = Made(table);
  Rng rng(22);
  const Eigen::Quaterniond truth = Eigen::Quaterniond::Identity();
  ConfusionView above;
  above.q_world_camera = OrientationSeenFrom(Eigen::Vector3d::UnitZ(), 0.0).conjugate();
  above.q_world_object = truth * object.Turn(1);
  ConfusionView front;
  front.q_world_camera = OrientationSeenFrom(Eigen::Vector3d::UnitX(), 0.0).conjugate();
  const auto belief = ModeBelief(model, {above, front});
  EXPECT_GT(ProbabilityNear(belief, truth, 3.0 * kDegree), 0.9);
  EXPECT_TRUE(ModeBelief(model, {front}).empty());
  EXPECT_TRUE(ModeBelief(model, {}).empty());
}

}  // namespace
}  // namespace vantage
