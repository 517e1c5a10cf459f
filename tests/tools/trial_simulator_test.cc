#include "tools/contingency/trial_simulator.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <limits>
#include <string>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confusion/viewing_direction.h"

namespace vantage {
namespace {

ObjectModel Model(const std::string& name) {
  Result<ObjectModel> model =
      LoadObjectModel(std::filesystem::path(VANTAGE_SOURCE_DIR) / "models" / name);
  EXPECT_TRUE(model.ok());
  return std::move(model).value();
}

std::unique_ptr<TrialSimulator> Simulator(const std::string& name,
                                          const TrialParameters& parameters = {}) {
  Result<std::unique_ptr<TrialSimulator>> simulator =
      TrialSimulator::Create(Model(name), parameters);
  EXPECT_TRUE(simulator.ok());
  return std::move(simulator).value();
}

// Share of trials that find the object, and find it turned right.
std::array<double, 2> Shares(const std::string& name, const TrialParameters& parameters) {
  constexpr int kTrials = 40;
  const SymmetryGroup symmetry = Model(name).symmetry;
  const std::unique_ptr<TrialSimulator> simulator = Simulator(name, parameters);
  Rng rng(3);
  std::array<double, 2> shares = {};
  for (int i = 0; i < kTrials; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const auto found = simulator->Detect(truth, static_cast<uint64_t>(i));
    if (!found) continue;
    shares[0] += 1.0 / kTrials;
    if (SymmetricAngle(symmetry, truth, *found) < 6.0 * kDegree) shares[1] += 1.0 / kTrials;
  }
  return shares;
}

// A box's faces are as flat as the wall, a jug is the largest.
TEST(TrialSimulator, FindsObjectsFromAnywhere) {
  for (const char* name : {"carton", "pitcher", "bracket"}) {
    const auto [found, right] = Shares(name, {});
    EXPECT_GE(found, 0.95) << name;
    EXPECT_GE(right, 0.9) << name;
  }
}

TEST(TrialSimulator, ShotFindsObjectsToo) {
  TrialParameters parameters;
  parameters.estimator = "shot";
  const auto [found, right] = Shares("duck", parameters);
  EXPECT_GE(found, 0.9);
  EXPECT_GE(right, 0.7);
}

TEST(TrialSimulator, OneSeedIsOneOutcomeWhateverWasAskedBefore) {
  const std::unique_ptr<TrialSimulator> a = Simulator("hub");
  const std::unique_ptr<TrialSimulator> b = Simulator("hub");
  Rng rng(4);
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const Eigen::Quaterniond truth = rng.Rotation();
    const auto first = a->Detect(truth, seed);
    b->Detect(rng.Rotation(), seed + 100);
    const auto second = b->Detect(truth, seed);
    const auto again = a->Detect(truth, seed);
    const auto other = a->Detect(truth, seed + 1);
    ASSERT_TRUE(first && second && again && other);
    EXPECT_EQ(first->coeffs(), second->coeffs());
    EXPECT_EQ(first->coeffs(), again->coeffs());
    EXPECT_NE(first->coeffs(), other->coeffs());
  }
}

// Nothing but the object tells the camera's roll: the hub's boss is seen or hidden at every roll.
TEST(TrialSimulator, ConfusionDependsOnTheViewingDirectionAlone) {
  const std::unique_ptr<TrialSimulator> simulator = Simulator("hub");
  constexpr int kTrials = 16;
  for (const bool from_below : {false, true}) {
    int right = 0;
    for (int i = 0; i < kTrials; ++i) {
      const Eigen::Vector3d direction =
          Eigen::Vector3d(0.02, 0.01, from_below ? -1.0 : 1.0).normalized();
      const Eigen::Quaterniond truth = OrientationSeenFrom(direction, 0.4 * i);
      const auto found = simulator->Detect(truth, static_cast<uint64_t>(i));
      right += found && GeodesicAngle(truth, *found) < 6.0 * kDegree ? 1 : 0;
    }
    if (from_below) {
      EXPECT_GT(right, 0);
      EXPECT_LE(right, 10);  // A quarter is expected.
    } else {
      EXPECT_GE(right, 15);
    }
  }
}

TEST(TrialSimulator, BadParametersAreNamed) {
  const ObjectModel model = Model("carton");
  const auto message = [&](const TrialParameters& parameters) {
    const auto made = TrialSimulator::Create(model, parameters);
    return made.ok() ? std::string() : made.error().message;
  };
  TrialParameters parameters;
  parameters.estimator = "icp";
  EXPECT_NE(message(parameters).find("\"icp\""), std::string::npos);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {kNaN, 0.0, -1.0, 11.0}) {
    parameters = {};
    parameters.nearest_distance = bad;
    EXPECT_NE(message(parameters).find("nearest_distance"), std::string::npos) << bad;
  }
  parameters = {};
  parameters.farthest_distance = 0.5;
  EXPECT_NE(message(parameters).find("farthest_distance = 0.5"), std::string::npos);
  parameters = {};
  parameters.aim_jitter = 0.2;
  EXPECT_NE(message(parameters).find("aim_jitter"), std::string::npos);
  parameters = {};
  parameters.camera.fx = 0.0;
  EXPECT_NE(message(parameters).find("fx"), std::string::npos);
  parameters = {};
  parameters.sensor.baseline = kNaN;
  EXPECT_NE(message(parameters).find("baseline"), std::string::npos);
}

TEST(TrialTexts, ChangeWithParametersButNotWithSeeds) {
  const TrialParameters plain;
  TrialParameters other;
  other.sensor.seed = 9;
  other.sensor.device_id = 9;
  EXPECT_EQ(SensorText(plain), SensorText(other));
  other.aim_jitter = 0.01;
  EXPECT_NE(SensorText(plain), SensorText(other));
  other = {};
  other.camera.cx += 1.0;
  EXPECT_NE(SensorText(plain), SensorText(other));
  other = {};
  other.ppf.voting.spread += 0.01;
  EXPECT_NE(EstimatorText(plain), EstimatorText(other));
  other = {};
  other.shot.shot.k += 1;
  EXPECT_EQ(EstimatorText(plain), EstimatorText(other));  // Which is not of "ppf".
  other.estimator = "shot";
  TrialParameters shot;
  shot.estimator = "shot";
  EXPECT_NE(EstimatorText(shot), EstimatorText(other));
  EXPECT_EQ(EstimatorText(plain).rfind("version ", 0), 0U);
}

}  // namespace
}  // namespace vantage
