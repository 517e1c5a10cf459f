#include "perception/calibration/input_mistakes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

using Kind = RawPose::Rotation;

Eigen::Vector3d NormalVector(double sigma, Rng& rng) {
  return sigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
}

Pose MakePose(const Eigen::Vector3d& rotation_vector, const Eigen::Vector3d& translation) {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3(rotation_vector).toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

RawPose Written(const Pose& pose, Kind kind) {
  RawPose raw = RawFromPose(pose);
  const Eigen::Quaterniond q(pose.linear());
  raw.kind = kind;
  if (kind == Kind::kQuaternion) raw.rotation = {q.w(), q.x(), q.y(), q.z()};
  if (kind == Kind::kRotationVector) {
    const Eigen::Vector3d vector = LogSo3(q);
    raw.rotation = {vector.x(), vector.y(), vector.z()};
  }
  return raw;
}

// Views of an arm that turns its camera about a target, with noise; some poses are wrong.
struct Simulation {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  Kind kind = Kind::kQuaternion;
  int num_views = 20;
  int num_outliers = 0;
  double noise = 1.0;  ///< times 0.5 mm and 0.1 deg
  double turn = 0.4;   ///< rad, standard deviation about each axis
};

std::vector<RawView> Simulate(const Simulation& simulation, uint64_t seed) {
  Rng rng(seed);
  const Pose T_x = MakePose(NormalVector(1.0, rng), NormalVector(0.1, rng));
  const Pose T_y = MakePose(NormalVector(1.0, rng), NormalVector(0.4, rng));
  std::vector<RawView> views;
  for (int i = 0; i < simulation.num_views; ++i) {
    // The target in front of the camera; the hand where it must then be.
    const Pose B = MakePose(NormalVector(simulation.turn, rng),
                            Eigen::Vector3d(0.0, 0.0, 0.6) + NormalVector(0.1, rng));
    const Pose A = T_y * B.inverse() * T_x.inverse();
    Pose seen = B;
    const double sigma = simulation.noise * 5e-4;
    seen = MakePose(NormalVector(3.5 * sigma, rng), NormalVector(sigma, rng)) * seen;
    if (i < simulation.num_outliers) {
      seen = MakePose(NormalVector(0.17, rng), NormalVector(0.03, rng)) * seen;
    }
    const bool in_hand = simulation.setup == HandEyeSetup::kEyeInHand;
    views.push_back({std::to_string(i),
                     0,
                     Written(in_hand ? A : A.inverse(), simulation.kind),
                     Written(seen, simulation.kind)});
  }
  return views;
}

template <class Change>
std::vector<RawView> Changed(std::vector<RawView> views, const Change& change) {
  for (RawView& view : views) change(view);
  return views;
}

RawPose Inverse(const RawPose& raw) { return Written(PoseFromRaw(raw)->inverse(), raw.kind); }

InputDiagnosis Diagnose(const std::vector<RawView>& views,
                        HandEyeSetup setup = HandEyeSetup::kEyeInHand) {
  return DiagnoseInput(setup, views, InputSource::kPosesAndPoses, 1);
}

// Of all that is told of `views`, one mistake that holds the words.
void ExpectMistake(const std::vector<RawView>& views,
                   const std::string& words,
                   HandEyeSetup setup = HandEyeSetup::kEyeInHand) {
  const InputDiagnosis diagnosis = Diagnose(views, setup);
  ASSERT_EQ(diagnosis.mistakes.size(), 1U) << words << ": " << diagnosis.Text();
  EXPECT_NE(diagnosis.mistakes.front().cause.find(words), std::string::npos) << diagnosis.Text();
  EXPECT_LT(diagnosis.mistakes.front().residual.translation, 0.005) << diagnosis.Text();
  EXPECT_FALSE(diagnosis.IsSound());
}

TEST(InputMistakes, NothingIsSaidOfWhatFits) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    for (const Kind kind : {Kind::kQuaternion, Kind::kRotationVector, Kind::kMatrix}) {
      for (const int num_outliers : {0, 6}) {
        for (const double noise : {0.0, 1.0, 10.0}) {
          for (const double turn : {0.05, 0.4}) {
            const Simulation simulation = {setup, kind, 20, num_outliers, noise, turn};
            const InputDiagnosis diagnosis = Diagnose(Simulate(simulation, 3), setup);
            EXPECT_TRUE(diagnosis.IsSound())
                << diagnosis.Text() << " kind " << static_cast<int>(kind) << " outliers "
                << num_outliers << " noise " << noise << " turn " << turn;
            EXPECT_EQ(diagnosis.Text(), "");
            EXPECT_TRUE(diagnosis.warnings.empty());
          }
        }
      }
    }
  }
}

TEST(InputMistakes, NothingIsSaidOfFewViewsThatFit) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    for (int num_views = 4; num_views < 9; ++num_views) {
      const Simulation simulation = {.num_views = num_views};
      const InputDiagnosis diagnosis = Diagnose(Simulate(simulation, seed));
      EXPECT_TRUE(diagnosis.IsSound()) << diagnosis.Text() << " of " << num_views;
    }
  }
}

TEST(InputMistakes, InvertedPosesAreNamed) {
  for (const int num_outliers : {0, 5}) {
    const Simulation simulation = {.num_outliers = num_outliers};
    const std::vector<RawView> right = Simulate(simulation, 5);
    ExpectMistake(Changed(right, [](RawView& view) { view.camera = Inverse(view.camera); }),
                  "the camera poses are inverted");
    ExpectMistake(Changed(right, [](RawView& view) { view.hand = Inverse(view.hand); }),
                  "the robot poses are inverted");
  }
}

// Both fit: A X B = Y is A^-1 Y B^-1 = X, and B Y^-1 A = X^-1.
TEST(InputMistakes, WhatFitsWithATargetBehindTheCameraIsDoubted) {
  const std::vector<RawView> right = Simulate({}, 5);
  const InputDiagnosis inverted = Diagnose(Changed(right, [](RawView& view) {
    view.hand = Inverse(view.hand);
    view.camera = Inverse(view.camera);
  }));
  EXPECT_TRUE(inverted.IsSound()) << inverted.Text();
  ASSERT_EQ(inverted.warnings.size(), 1U);
  EXPECT_NE(inverted.warnings.front().find("both inverted"), std::string::npos);
  const InputDiagnosis exchanged =
      Diagnose(Changed(right, [](RawView& view) { std::swap(view.hand, view.camera); }));
  EXPECT_TRUE(exchanged.IsSound()) << exchanged.Text();
  ASSERT_EQ(exchanged.warnings.size(), 1U);
  EXPECT_NE(exchanged.warnings.front().find("exchanged"), std::string::npos);
}

TEST(InputMistakes, TheOtherSetupIsNamed) {
  ExpectMistake(Simulate({.setup = HandEyeSetup::kEyeToHand}, 6), "--setup eye-to-hand");
  ExpectMistake(Simulate({}, 6), "--setup eye-in-hand", HandEyeSetup::kEyeToHand);
}

TEST(InputMistakes, UnitsAreNamed) {
  const std::vector<RawView> right =
      Simulate({.kind = Kind::kRotationVector, .num_outliers = 5}, 7);
  const auto scale = [](double factor, RawPose& pose) { pose.translation *= factor; };
  ExpectMistake(Changed(right, [&](RawView& view) { scale(1e3, view.hand); }),
                "the robot's translations are in millimeters");
  ExpectMistake(Changed(right, [&](RawView& view) { scale(1e3, view.camera); }),
                "the camera's translations are in millimeters");
  const InputDiagnosis both = Diagnose(Changed(right, [&](RawView& view) {
    scale(1e3, view.hand);
    scale(1e3, view.camera);
  }));
  EXPECT_FALSE(both.IsSound());
  EXPECT_NE(both.Text().find("millimeters for meters?"), std::string::npos) << both.Text();

  const auto to_degrees = [](RawPose& pose) {
    for (double& value : pose.rotation) value /= kDegree;
  };
  ExpectMistake(Changed(right, [&](RawView& view) { to_degrees(view.hand); }),
                "the robot's rotation vectors are in degrees");
  ExpectMistake(Changed(right, [&](RawView& view) { to_degrees(view.camera); }),
                "the camera's rotation vectors are in degrees");
  ExpectMistake(Changed(right,
                        [&](RawView& view) {
                          to_degrees(view.hand);
                          to_degrees(view.camera);
                        }),
                "the robot's and the camera's rotation vectors are in degrees");
}

TEST(InputMistakes, TheOrderOfQuaternionsIsNamed) {
  const std::vector<RawView> right = Simulate({.num_outliers = 5}, 8);
  const auto turn = [](RawPose& pose) {  // w, x, y, z to x, y, z, w.
    pose.rotation = {pose.rotation[1], pose.rotation[2], pose.rotation[3], pose.rotation[0]};
  };
  ExpectMistake(Changed(right, [&](RawView& view) { turn(view.hand); }),
                "the robot's quaternions are in the order x, y, z, w");
  ExpectMistake(Changed(right, [&](RawView& view) { turn(view.camera); }),
                "the camera's quaternions are in the order x, y, z, w");
  ExpectMistake(Changed(right,
                        [&](RawView& view) {
                          turn(view.hand);
                          turn(view.camera);
                        }),
                "the robot's and the camera's quaternions are in the order x, y, z, w");
}

TEST(InputMistakes, MirroredRotationsAreNamed) {
  const std::vector<RawView> right = Simulate({.kind = Kind::kMatrix, .num_outliers = 5}, 9);
  const auto transpose = [](RawPose& pose) {
    std::swap(pose.rotation[1], pose.rotation[3]);
    std::swap(pose.rotation[2], pose.rotation[6]);
    std::swap(pose.rotation[5], pose.rotation[7]);
  };
  ExpectMistake(Changed(right, [&](RawView& view) { transpose(view.hand); }),
                "the robot's rotations are transposed");
  // Which of the axes is turned round, and whether of hand or camera, makes no difference.
  const auto negate_first_column = [](RawPose& pose) {
    for (const size_t i : {0U, 3U, 6U}) pose.rotation[i] *= -1.0;
  };
  const std::vector<RawView> mirrored =
      Changed(right, [&](RawView& view) { negate_first_column(view.hand); });
  EXPECT_NE(PoseFromRaw(mirrored.front().hand).error().message.find("determinant -1"),
            std::string::npos);
  ExpectMistake(mirrored, "the robot's matrices mirror: one axis of what they place");
  const auto left_handed = [](RawPose& pose) {
    pose.translation.y() *= -1.0;
    for (const size_t i : {1U, 3U, 5U, 7U}) pose.rotation[i] *= -1.0;
  };
  const InputDiagnosis diagnosis =
      Diagnose(Changed(right, [&](RawView& view) { left_handed(view.hand); }));
  ASSERT_EQ(diagnosis.mistakes.size(), 2U) << diagnosis.Text();
  EXPECT_NE(diagnosis.Text().find("or, about as well, if the camera's axes are left-handed"),
            std::string::npos)
      << diagnosis.Text();
}

TEST(InputMistakes, ShiftedRowsAreNamed) {
  const std::vector<RawView> right = Simulate({}, 10);
  std::vector<RawView> shifted(right.begin(), right.end() - 1);
  for (size_t i = 0; i < shifted.size(); ++i) shifted[i].hand = right[i + 1].hand;
  ExpectMistake(shifted, "one row earlier");
  for (size_t i = 0; i < shifted.size(); ++i) {
    shifted[i].hand = right[i].hand;
    shifted[i].camera = right[i + 1].camera;
  }
  ExpectMistake(shifted, "one row later");
}

TEST(InputMistakes, TwoAtOnceAreNamed) {
  const std::vector<RawView> right = Simulate({}, 11);
  ExpectMistake(Changed(right,
                        [](RawView& view) {
                          view.camera = Inverse(view.camera);
                          view.hand.translation *= 1e3;
                        }),
                "the robot's translations are in millimeters (meters are expected), and the camera "
                "poses are inverted (");
}

TEST(InputMistakes, WhatADetectorMeasuredIsNotDoubted) {
  const std::vector<RawView> right = Simulate({}, 12);
  const auto turned = Changed(right, [](RawView& view) {
    const std::array<double, 9>& q = view.camera.rotation;
    view.camera.rotation = {q[1], q[2], q[3], q[0]};
  });
  const InputDiagnosis diagnosis =
      DiagnoseInput(HandEyeSetup::kEyeInHand, turned, InputSource::kPosesAndImages, 1);
  EXPECT_TRUE(diagnosis.mistakes.empty()) << diagnosis.Text();
  EXPECT_NE(diagnosis.Text().find("contradict each other"), std::string::npos) << diagnosis.Text();
}

TEST(InputMistakes, PosesThatDoNotMoveAreNamed) {
  std::vector<RawView> views = Simulate({}, 13);
  for (RawView& view : views) view.hand = views.front().hand;
  EXPECT_NE(Diagnose(views).Text().find("the robot poses are all the same"), std::string::npos);
  views = Simulate({}, 13);
  for (RawView& view : views) view.camera = views.front().camera;
  EXPECT_NE(Diagnose(views).Text().find("the camera poses are all the same"), std::string::npos);
}

TEST(InputMistakes, ChanceFitsNothing) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    std::vector<RawView> views = Simulate({}, seed);
    const std::vector<RawView> others = Simulate({}, seed + 100);
    for (size_t i = 0; i < views.size(); ++i) views[i].camera = others[i].camera;
    const InputDiagnosis diagnosis = Diagnose(views);
    EXPECT_TRUE(diagnosis.mistakes.empty()) << diagnosis.Text();
    EXPECT_FALSE(diagnosis.IsSound());
  }
}

TEST(RawPose, WhatIsNoPoseIsRefused) {
  RawPose raw;
  EXPECT_TRUE(PoseFromRaw(raw).ok());
  raw.translation.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(PoseFromRaw(raw).ok());
  raw.translation.y() = 1e300;
  EXPECT_FALSE(PoseFromRaw(raw).ok());
  raw = {.kind = Kind::kRotationVector, .rotation = {0.0, 57.3, 0.0}};
  EXPECT_NE(PoseFromRaw(raw).error().message.find("degrees for radians?"), std::string::npos);
  raw.rotation[1] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(PoseFromRaw(raw).ok());
  raw = {.kind = Kind::kMatrix, .rotation = {1, 0, 0, 0, 1, 0, 0, 0, -1}};
  EXPECT_NE(PoseFromRaw(raw).error().message.find("left-handed"), std::string::npos);
  raw.rotation = {};
  EXPECT_FALSE(PoseFromRaw(raw).ok());
  raw = {.rotation = {0.9, 0.0, 0.0, 0.0}};
  EXPECT_FALSE(PoseFromRaw(raw).ok());
}

TEST(RawPose, EveryNotationGivesThePoseBack) {
  Rng rng(2);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = MakePose(NormalVector(1.0, rng), NormalVector(1.0, rng));
    for (const Kind kind : {Kind::kQuaternion, Kind::kRotationVector, Kind::kMatrix}) {
      EXPECT_TRUE(PoseFromRaw(Written(pose, kind))->isApprox(pose, 1e-12));
    }
  }
}

}  // namespace
}  // namespace vantage
