#include "planner/stop_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

class StopRule : public testing::Test {
 protected:
  StopRule() {
    known_.confirmed = true;
    known_.converged = true;
    known_.confusion = &model_;
    known_.belief = sure_;
    plain_.confirmed = true;
    plain_.converged = true;
  }
  static std::string Reason(const std::vector<PlannedObject>& objects,
                            std::optional<double> information = {}) {
    return StopReason({}, objects, information, 5);
  }

  ConfusionModel model_ = MakeConfusion(RandomTurns(4, 20, 1));
  std::vector<OrientationHypothesis> sure_ = {{Eigen::Quaterniond::Identity(), 0.97}};
  std::vector<OrientationHypothesis> unsure_ = {{Eigen::Quaterniond::Identity(), 0.9}};
  PlannedObject known_;
  PlannedObject plain_;
};

TEST_F(StopRule, WithoutConfusionModelsConvergenceIsEnough) {
  EXPECT_EQ(Reason({}), "");
  EXPECT_EQ(Reason({plain_, plain_}), "all 2 confirmed objects converged after 5 views");
  EXPECT_NE(Reason({plain_}, 3.0), "");  // Nobody knows what a gain would be about.
  PlannedObject tentative = plain_;
  tentative.confirmed = false;
  EXPECT_EQ(Reason({tentative}), "");
  tentative.converged = false;
  EXPECT_NE(Reason({plain_, tentative}), "");
  plain_.converged = false;
  EXPECT_EQ(Reason({known_, plain_}, 0.0), "");
}

TEST_F(StopRule, WithOneTheBeliefMustBeSureAndNothingLeftToGain) {
  EXPECT_EQ(Reason({known_, plain_}, 0.01),
            "all 2 confirmed objects converged after 5 views, the least sure of 1 orientations to "
            "97.0 %, and no view left is expected to tell more than 0.01 nat");
  EXPECT_NE(Reason({known_}), "");  // By a criterion that does not know.
  EXPECT_EQ(Reason({known_}, 0.06), "");
  PlannedObject unsure = known_;
  unsure.belief = unsure_;
  EXPECT_EQ(Reason({known_, unsure}, 0.0), "");
  known_.converged = false;
  EXPECT_EQ(Reason({known_}, 0.0), "");
}

TEST_F(StopRule, ParametersAreChecked) {
  EXPECT_TRUE(StopParameters().Validate().ok());
  for (const StopParameters& wrong : std::vector<StopParameters>{
           {-0.1, 0.95}, {NAN, 0.95}, {INFINITY, 0.95}, {0.1, 0.0}, {0.1, 1.0}, {0.1, NAN}}) {
    EXPECT_FALSE(wrong.Validate().ok()) << wrong.least_gain << " " << wrong.sure;
  }
}

}  // namespace
}  // namespace vantage
