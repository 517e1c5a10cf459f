#include "perception/calibration/observability.h"

#include <gtest/gtest.h>

#include "perception/calibration/pose_calibration.h"
#include "tests/perception/calibration/simulated_pose_views.h"

namespace vantage {
namespace {

constexpr HandEyeSetup kSetups[] = {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand};

/// Calibrations that are held sufficient, and the last reason.
struct Count {
  int sufficient = 0;
  int trials = 0;
  std::string reason;
};

Count CountSufficient(SimulatedPoseRequest request, uint64_t first_seed) {
  Count count;
  for (const HandEyeSetup setup : kSetups) {
    for (uint64_t seed = first_seed; seed < first_seed + 25; ++seed) {
      Rng rng(seed);
      request.setup = setup;
      const SimulatedPoseViews made = SimulatePoseViews(request, rng);
      const Result<HandEyeResult> result = CalibrateFromPoses(setup, made.views, {});
      ++count.trials;
      if (!result) {
        count.reason = result.error().message;
        continue;
      }
      count.sufficient += result->observability.is_sufficient ? 1 : 0;
      count.reason = result->observability.reason;
    }
  }
  return count;
}

TEST(Observability, AcceptsGenericMotions) {
  for (const int views : {20, 50}) {
    for (const double share : {0.0, 0.3}) {
      SimulatedPoseRequest request;
      request.views = views;
      request.outlier_share = share;
      const Count count = CountSufficient(request, 100);
      EXPECT_EQ(count.sufficient, count.trials) << count.reason;
    }
  }
}

TEST(Observability, NamesTheOnlyAxis) {
  SimulatedPoseRequest request;
  request.turns = {0.0, 0.6, 0.0};
  for (const double share : {0.0, 0.3}) {
    request.outlier_share = share;
    const Count count = CountSufficient(request, 200);
    EXPECT_EQ(count.sufficient, 0);
    EXPECT_NE(count.reason.find("about one axis"), std::string::npos) << count.reason;
    EXPECT_NE(count.reason.find("add views rotated about another axis"), std::string::npos);
  }
  // In the hand's axes it is y.
  Rng rng(1);
  request.outlier_share = 0.0;
  const SimulatedPoseViews made = SimulatePoseViews(request, rng);
  const Result<HandEyeResult> result = CalibrateFromPoses(made.setup, made.views, {});
  ASSERT_TRUE(result);
  EXPECT_NE(result->observability.reason.find("(0.00, 1.00, 0.00) in the hand's axes"),
            std::string::npos)
      << result->observability.reason;
}

TEST(Observability, NamesMissingRotationAndMissingMotion) {
  SimulatedPoseRequest request;
  request.turns.setZero();
  const Count shifted = CountSufficient(request, 300);
  EXPECT_EQ(shifted.sufficient, 0);
  EXPECT_NE(shifted.reason.find("turns by"), std::string::npos) << shifted.reason;
  request.travel.setZero();
  const Count identical = CountSufficient(request, 400);
  EXPECT_EQ(identical.sufficient, 0);
  EXPECT_NE(identical.reason.find("same pose of the hand"), std::string::npos) << identical.reason;
}

TEST(Observability, TellsHowLittleIsKnown) {
  const std::vector<Pose> hands = {MakePose(ExpSo3({0.5, 0.0, 0.0}), {0.1, 0.0, 0.0}),
                                   MakePose(ExpSo3({0.0, 0.5, 0.0}), {0.0, 0.1, 0.0}),
                                   MakePose(ExpSo3({0.0, 0.0, 0.5}), {0.0, 0.0, 0.1})};
  HandEyeCovariance covariance = 1e-8 * HandEyeCovariance::Identity();
  EXPECT_TRUE(AssessObservability(HandEyeSetup::kEyeInHand, hands, covariance, 0.0).is_sufficient);
  covariance(5, 5) = 0.04 * 0.04;  // m^2, along z.
  const Observability weak = AssessObservability(HandEyeSetup::kEyeInHand, hands, covariance, 0.0);
  EXPECT_FALSE(weak.is_sufficient);
  EXPECT_NE(weak.reason.find("40 mm along (0.00, 0.00, 1.00)"), std::string::npos) << weak.reason;
  EXPECT_NEAR(weak.singular_values[5], 1.0 / 40.0, 1e-9);  // Per mm.
  EXPECT_NEAR(weak.singular_values[0], 0.1 * kDegree / 1e-4, 1e-6);
}

}  // namespace
}  // namespace vantage
