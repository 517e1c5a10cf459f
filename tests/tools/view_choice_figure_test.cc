#include "tools/support/view_choice_figure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/so3.h"

namespace vantage {
namespace {

next_view_t DecisionOfThree() {
  next_view_t decision{};
  decision.criterion = "information_gain";
  decision.selected = 1;
  for (int i = 0; i < 3; ++i) {
    const Pose pose = LookAt({0.5, 0.2 * (i - 1), 0.5}, Eigen::Vector3d::Zero());
    view_candidate_t candidate{};
    const Eigen::Quaterniond q(pose.linear());
    for (int axis = 0; axis < 3; ++axis) candidate.trans[axis] = pose.translation()[axis];
    candidate.quat[0] = q.w();
    for (int axis = 0; axis < 3; ++axis) candidate.quat[1 + axis] = q.vec()[axis];
    candidate.gain = 0.1 * i;
    candidate.reason = i == 2 ? "refused by the robot: too far at 1.2 m" : "";
    decision.candidates.push_back(candidate);
  }
  decision.num_candidates = 3;
  return decision;
}

TEST(ViewChoiceFigure, ShowsOpenRejectedAndSelected) {
  const Result<std::string> svg = ViewChoiceFigure(DecisionOfThree());
  ASSERT_TRUE(svg.ok()) << svg.error().message;
  EXPECT_NE(svg->find("<svg"), std::string::npos);
  EXPECT_NE(svg->find("rgb(209,  73,  91)"), std::string::npos);  // The selected one's ring,
  EXPECT_NE(svg->find("rgb(170, 170, 170)"), std::string::npos);  // the rejected one's cross.
  next_view_t none_selected = DecisionOfThree();
  none_selected.selected = -1;
  const Result<std::string> without = ViewChoiceFigure(none_selected);
  ASSERT_TRUE(without.ok());
  EXPECT_EQ(without->find("rgb(209,  73,  91)"), std::string::npos);
}

TEST(ViewChoiceFigure, IsEmptyWithoutCandidates) {
  const Result<std::string> svg = ViewChoiceFigure(next_view_t{});
  ASSERT_TRUE(svg.ok());
  EXPECT_EQ(*svg, "");
  EXPECT_EQ(RejectionText(next_view_t{}), "");
}

TEST(ViewChoiceFigure, LeavesOutWhatIsNoPose) {
  next_view_t decision = DecisionOfThree();
  for (view_candidate_t& candidate : decision.candidates) candidate.quat[0] = NAN;
  const Result<std::string> svg = ViewChoiceFigure(decision);
  ASSERT_TRUE(svg.ok());
  EXPECT_EQ(*svg, "");
}

TEST(RejectionText, CountsKindsOfReasons) {
  next_view_t decision = DecisionOfThree();
  decision.candidates[0].reason = "visited";
  decision.candidates.push_back(decision.candidates[2]);
  EXPECT_EQ(RejectionText(decision),
            "4 candidates by information_gain, 3 of them rejected: 2 refused by the robot, 1 "
            "visited.");
}

}  // namespace
}  // namespace vantage
