#include "drivers/sim/sim_hand.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/rng.h"

namespace vantage {
namespace {

Pose Somewhere(Rng* rng) {
  Pose pose = Pose::Identity();
  pose.linear() = rng->Rotation().toRotationMatrix();
  pose.translation() = 0.5 * Eigen::Vector3d(rng->Normal(), rng->Normal(), rng->Normal());
  return pose;
}

SimHandParameters Parameters() {
  SimHandParameters parameters;
  parameters.T_hand_camera = Eigen::Translation3d(0.03, -0.06, 0.05) *
                             Eigen::AngleAxisd(0.8, Eigen::Vector3d(1.0, 2.0, -0.5).normalized());
  return parameters;
}

TEST(SimHand, WithoutNoiseItKnowsWhereItIs) {
  const SimHand hand(Parameters());
  Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    const Pose T_base_hand = Somewhere(&rng);
    EXPECT_TRUE(hand.Believed(hand.CameraAt(T_base_hand)).isApprox(T_base_hand, 1e-12));
    EXPECT_TRUE(
        hand.CameraAt(T_base_hand).isApprox(T_base_hand * Parameters().T_hand_camera, 1e-12));
  }
}

TEST(SimHand, ErrorsHaveTheirSigmaAreSmoothAndTheSeedsOwn) {
  SimHandParameters parameters = Parameters();
  parameters.translation_sigma = 1e-4;
  parameters.rotation_sigma = 2e-4;
  const SimHand hand(parameters);
  const SimHand same(parameters);
  parameters.seed = 2;
  const SimHand other(parameters);
  Rng rng(7);
  double translation = 0.0;
  double rotation = 0.0;
  constexpr int kTrials = 2000;
  for (int i = 0; i < kTrials; ++i) {
    const Pose truth = Somewhere(&rng);
    const Pose camera = hand.CameraAt(truth);
    const Pose believed = hand.Believed(camera);
    EXPECT_TRUE(believed.isApprox(same.Believed(camera), 0.0));
    EXPECT_FALSE(believed.isApprox(other.Believed(camera), 1e-9));
    translation += (believed.translation() - truth.translation()).squaredNorm() / (3.0 * kTrials);
    const double angle =
        GeodesicAngle(Eigen::Quaterniond(believed.linear()), Eigen::Quaterniond(truth.linear()));
    rotation += angle * angle / (3.0 * kTrials);
    // A tenth of a millimetre farther the error is the same.
    Pose near = truth;
    near.translation().x() += 1e-4;
    const Eigen::Vector3d change =
        hand.Believed(hand.CameraAt(near)).translation() - believed.translation();
    EXPECT_LT((change - Eigen::Vector3d(1e-4, 0.0, 0.0)).norm(), 1e-5);
  }
  EXPECT_NEAR(std::sqrt(translation), 1e-4, 1e-5);
  EXPECT_NEAR(std::sqrt(rotation), 2e-4, 2e-5);
}

TEST(SimHand, ImplausibleParametersAreRefused) {
  SimHandParameters parameters = Parameters();
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.translation_sigma = -1e-4;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = Parameters();
  parameters.rotation_sigma = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = Parameters();
  parameters.T_hand_camera.translation().x() = 11.0;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
