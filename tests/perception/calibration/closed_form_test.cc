#include "perception/calibration/closed_form.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/perception/calibration/simulated_pose_views.h"

namespace vantage {
namespace {

std::vector<HandEyeEquation> EquationsOf(const SimulatedPoseViews& made) {
  std::vector<HandEyeEquation> equations;
  for (const PoseView& view : made.views) {
    equations.push_back({EquationOfHand(made.setup, view.T_base_hand), view.T_camera_target});
  }
  return equations;
}

HandEyeNoise NoNoise() { return {0.0, 0.0, 0.0, 0.0, 0.0}; }

TEST(ClosedForm, IsExactWithoutNoise) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    for (const int views : {3, 10}) {
      Rng rng(7);
      SimulatedPoseRequest request;
      request.setup = setup;
      request.views = views;
      request.noise = NoNoise();
      const SimulatedPoseViews made = SimulatePoseViews(request, rng);
      for (const ClosedForm& form : ClosedForms()) {
        const auto solution = form.solve(EquationsOf(made));
        ASSERT_TRUE(solution) << form.name;
        EXPECT_LT(ErrorOf(solution->T_x, made.T_x).norm(), 1e-8) << form.name;
        EXPECT_LT(ErrorOf(solution->T_y, made.T_y).norm(), 1e-8) << form.name;
      }
    }
  }
}

// Of rotations about one axis only the translation along it is open; of pure translations the
// translation, while the rotation is told.
TEST(ClosedForm, ParkTellsWhatDegenerateMotionsTell) {
  SimulatedPoseRequest request;
  request.noise = NoNoise();
  request.turns = {0.0, 0.0, 0.6};
  Rng rng(3);
  const SimulatedPoseViews one_axis = SimulatePoseViews(request, rng);
  auto solution = SolvePark(EquationsOf(one_axis));
  ASSERT_TRUE(solution);
  Eigen::Matrix<double, 6, 1> error = ErrorOf(solution->T_x, one_axis.T_x);
  error[5] = 0.0;  // The hand turns about its z.
  EXPECT_LT(error.norm(), 1e-7);

  request.turns.setZero();
  const SimulatedPoseViews no_turn = SimulatePoseViews(request, rng);
  solution = SolvePark(EquationsOf(no_turn));
  ASSERT_TRUE(solution);
  EXPECT_LT(ErrorOf(solution->T_x, no_turn.T_x).head<3>().norm(), 1e-7);
}

TEST(ClosedForm, RefusesTooFewAndNotFinite) {
  Rng rng(5);
  SimulatedPoseRequest request;
  request.views = 5;
  std::vector<HandEyeEquation> equations = EquationsOf(SimulatePoseViews(request, rng));
  for (const ClosedForm& form : ClosedForms()) {
    EXPECT_FALSE(form.solve(std::span(equations).first(2))) << form.name;
    EXPECT_FALSE(form.solve({})) << form.name;
  }
  equations[2].B.translation().x() = std::numeric_limits<double>::quiet_NaN();
  for (const ClosedForm& form : ClosedForms()) EXPECT_FALSE(form.solve(equations)) << form.name;
}

}  // namespace
}  // namespace vantage
