#include "perception/calibration/consensus.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/perception/calibration/simulated_pose_views.h"

namespace vantage {
namespace {

int NumWrong(const Consensus& consensus, const SimulatedPoseViews& made) {
  int wrong = 0;
  for (size_t i = 0; i < made.views.size(); ++i) {
    wrong += (consensus.chosen[i] < 0) != made.is_outlier[i] ? 1 : 0;
  }
  return wrong;
}

TEST(Consensus, LeavesOutOutliers) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    for (const double share : {0.0, 0.3, 0.45}) {
      int wrong = 0;
      for (uint64_t seed = 0; seed < 40; ++seed) {
        Rng rng(seed);
        SimulatedPoseRequest request;
        request.setup = setup;
        request.outlier_share = share;
        const SimulatedPoseViews made = SimulatePoseViews(request, rng);
        const Result<Consensus> consensus = FindConsensus(setup, made.views, {}, 1);
        ASSERT_TRUE(consensus) << consensus.error().message;
        wrong += NumWrong(*consensus, made);
        EXPECT_LT(ErrorOf(consensus->T_x, made.T_x).tail<3>().norm(), 0.005);
      }
      EXPECT_LE(wrong, 4) << share;  // Of 1,200 views.
    }
  }
}

// A flat target has a second pose; half of the views name it first.
TEST(Consensus, ChoosesAmongPosesOfAView) {
  int wrong = 0;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed);
    SimulatedPoseViews made = SimulatePoseViews({}, rng);
    std::vector<int> truth;
    for (PoseView& view : made.views) {
      // Turned about an axis across the line of sight that differs from view to view.
      const double angle = rng.Uniform(0.0, 6.0);
      Pose flipped = view.T_camera_target;
      flipped.linear() =
          ExpSo3({0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.0}) * flipped.linear();
      view.other_T_camera_target = {flipped};
      truth.push_back(rng.Uniform() < 0.5 ? 1 : 0);
      if (truth.back() == 1) std::swap(view.T_camera_target, view.other_T_camera_target[0]);
    }
    const Result<Consensus> consensus = FindConsensus(made.setup, made.views, {}, 1);
    ASSERT_TRUE(consensus) << consensus.error().message;
    for (size_t i = 0; i < truth.size(); ++i) wrong += consensus->chosen[i] != truth[i] ? 1 : 0;
  }
  EXPECT_LE(wrong, 4);
}

// What the noise is told to be only weighs: ten times more or less finds the same views.
TEST(Consensus, FindsTheNoise) {
  for (const double factor : {0.1, 1.0, 10.0}) {
    Rng rng(11);
    SimulatedPoseRequest request;
    request.outlier_share = 0.3;
    const SimulatedPoseViews made = SimulatePoseViews(request, rng);
    HandEyeNoise noise;
    noise.robot_rotation *= factor;
    noise.robot_translation *= factor;
    noise.camera_rotation *= factor;
    noise.camera_translation *= factor;
    const Result<Consensus> consensus = FindConsensus(made.setup, made.views, noise, 1);
    ASSERT_TRUE(consensus);
    EXPECT_EQ(NumWrong(*consensus, made), 0);
    EXPECT_NEAR(consensus->noise_scale * factor, 1.4, 0.6);
  }
}

TEST(Consensus, IsTheSameForTheSameSeed) {
  Rng rng(2);
  SimulatedPoseRequest request;
  request.outlier_share = 0.3;
  const SimulatedPoseViews made = SimulatePoseViews(request, rng);
  const Result<Consensus> first = FindConsensus(made.setup, made.views, {}, 5);
  const Result<Consensus> second = FindConsensus(made.setup, made.views, {}, 5);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_x.matrix(), second->T_x.matrix());
  EXPECT_EQ(first->chosen, second->chosen);
}

TEST(Consensus, RefusesTooFewViews) {
  Rng rng(2);
  const SimulatedPoseViews made = SimulatePoseViews({}, rng);
  const auto few = FindConsensus(made.setup, std::span(made.views).first(2), HandEyeNoise(), 1);
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().message.find("2 views"), std::string::npos) << few.error().message;
}

}  // namespace
}  // namespace vantage
