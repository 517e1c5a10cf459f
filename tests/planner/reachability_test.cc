#include "planner/reachability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

TEST(Reachability, RefusalsNameWhatIsInTheWay) {
  ReachabilityParameters parameters;
  parameters.base = Eigen::Vector3d(-1.0, 0.0, 0.0);
  parameters.nearest = 0.2;
  parameters.farthest = 1.5;
  parameters.boxes = {{"wall", {0.3, -1.0, 0.0}, {0.4, 1.0, 2.0}}};
  parameters.spheres = {{"lamp", {0.0, 0.0, 0.5}, 0.1}};
  ASSERT_TRUE(parameters.Validate().ok());
  EXPECT_EQ(ReachRefusal(parameters, At(0.0, 0.0, 0.0)), "");
  EXPECT_EQ(ReachRefusal(parameters, At(0.35, 0.0, 0.1)), "in the keep-out volume \"wall\"");
  EXPECT_EQ(ReachRefusal(parameters, At(0.3, 0.0, 0.1)), "in the keep-out volume \"wall\"");
  EXPECT_EQ(ReachRefusal(parameters, At(0.29, 0.0, 0.1)), "");
  EXPECT_EQ(ReachRefusal(parameters, At(0.0, 0.05, 0.55)), "in the keep-out volume \"lamp\"");
  EXPECT_EQ(ReachRefusal(parameters, At(0.0, 0.2, 0.5)), "");
  EXPECT_EQ(ReachRefusal(parameters, At(1.0, 0.0, 0.0)),
            "out of reach: 2.00 m from the base, which reaches 0.20 to 1.50 m");
  EXPECT_NE(ReachRefusal(parameters, At(-1.0, 0.1, 0.0)), "");
  EXPECT_EQ(ReachRefusal({}, At(1e6, 0.0, 0.0)), "");
}

TEST(Reachability, ParametersAreChecked) {
  const auto is_valid = [](const auto& change) {
    ReachabilityParameters parameters;
    change(&parameters);
    return parameters.Validate().ok();
  };
  using P = ReachabilityParameters*;
  EXPECT_TRUE(is_valid([](P) {}));
  EXPECT_FALSE(is_valid([](P p) { p->nearest = -0.1; }));
  EXPECT_FALSE(is_valid([](P p) { p->nearest = NAN; }));
  EXPECT_FALSE(is_valid([](P p) { p->farthest = 0.0; }));
  EXPECT_FALSE(is_valid([](P p) { p->base.x() = INFINITY; }));
  EXPECT_FALSE(is_valid([](P p) { p->boxes = {{"box", {0, 0, 0}, {1, 1, 0}}}; }));
  EXPECT_FALSE(is_valid([](P p) { p->boxes = {{"", {0, 0, 0}, {1, 1, 1}}}; }));
  EXPECT_FALSE(is_valid([](P p) { p->boxes = {{"box", {0, NAN, 0}, {1, 1, 1}}}; }));
  EXPECT_FALSE(is_valid([](P p) { p->spheres = {{"ball", {0, 0, 0}, -1.0}}; }));
  EXPECT_FALSE(is_valid([](P p) { p->spheres = {{"ball", {0, 0, NAN}, 1.0}}; }));
}

}  // namespace
}  // namespace vantage
