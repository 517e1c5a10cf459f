#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "common/depth_rasterizer.h"
#include "common/rng.h"
#include "perception/model/mesh_primitives.h"
#include "perception/model/model_generator.h"
#include "tools/evaluate/pose_success.h"

namespace vantage {
namespace {

constexpr double kAway = 0.7;  // m

// A model without the samples that only estimators need.
ObjectModel ModelOf(const TriangleMesh& mesh, const SymmetryGroup& symmetry) {
  ObjectModel model;
  model.id = "test";
  model.mesh = mesh;
  model.symmetry = symmetry;
  model.center = mesh.SurfaceCentroid();
  model.diameter = mesh.Diameter();
  return model;
}

ObjectModel Generated(const std::string& name) {
  const Result<GeneratedObject> object = GenerateObject(name);
  return ModelOf(object->mesh, object->symmetry);
}

// The model's center before the camera, turned.
Pose Before(const ObjectModel& model, const Eigen::Quaterniond& rotation, double away = kAway) {
  Pose T = Pose::Identity();
  T.linear() = rotation.toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.02, -0.01, away) - T.linear() * model.center;
  return T;
}

// A turn of the object about an axis of its own through its center.
Pose TurnedBy(const ObjectModel& model, double angle, const Eigen::Vector3d& axis) {
  return Eigen::Translation3d(model.center) * Pose(Eigen::AngleAxisd(angle, axis)) *
         Eigen::Translation3d(-model.center);
}

DepthImage Measured(const ObjectModel& model, const Pose& T, const CameraModel& camera) {
  DepthRasterizer rasterizer(camera);
  rasterizer.Draw(model.mesh, T);
  DepthImage image(camera.width, camera.height);
  for (size_t i = 0; i < image.depth.size(); ++i) {
    const float depth = rasterizer.depth()[i];
    if (depth != DepthRasterizer::kEmpty) image.depth[i] = depth;
  }
  return image;
}

PoseSuccess Judge(const ObjectModel& model, const Pose& T_true, const Pose& T_estimated) {
  const CameraModel camera;
  return JudgePose(model, T_true, T_estimated, Measured(model, T_true, camera), camera);
}

TEST(PoseSuccess, TheTruthIsWithinAndIndistinguishable) {
  const ObjectModel model = Generated("bracket");
  Rng rng(1);
  for (int i = 0; i < 5; ++i) {
    const Pose T = Before(model, rng.Rotation());
    const PoseSuccess success = Judge(model, T, T);
    EXPECT_LT(success.angle, 1e-7);
    EXPECT_EQ(success.distance, 0.0);
    EXPECT_EQ(success.discrepancy, 0.0);
    EXPECT_EQ(success.deviation, 0.0);
    EXPECT_TRUE(success.is_within);
    EXPECT_TRUE(success.is_indistinguishable);
  }
}

TEST(PoseSuccess, SymmetricEquivalentsAreOnePose) {
  Rng rng(2);
  for (const char* name : {"carton", "gear", "bottle", "trefoil"}) {
    SCOPED_TRACE(name);
    const ObjectModel model = Generated(name);
    const Eigen::Quaterniond half_turn =
        model.symmetry.kind == SymmetryGroup::Kind::kFinite
            ? model.symmetry.elements.back()
            : Eigen::Quaterniond(Eigen::AngleAxisd(1.0, model.symmetry.axis));
    const Eigen::AngleAxisd turn(half_turn);
    const Pose T = Before(model, rng.Rotation());
    const PoseSuccess success = Judge(model, T, T * TurnedBy(model, turn.angle(), turn.axis()));
    EXPECT_LT(success.angle, 1e-6);
    EXPECT_LT(success.distance, 1e-9);
    EXPECT_TRUE(success.is_within);
    EXPECT_TRUE(success.is_indistinguishable) << success.discrepancy;
  }
}

TEST(PoseSuccess, BoundsOfAngleAndDistance) {
  const ObjectModel model = Generated("bracket");
  Rng rng(3);
  const Pose T = Before(model, rng.Rotation());
  const Eigen::Vector3d axis = rng.UnitVector();
  EXPECT_TRUE(Judge(model, T, T * TurnedBy(model, 4.9 * kDegree, axis)).is_within);
  const PoseSuccess beyond = Judge(model, T, T * TurnedBy(model, 5.1 * kDegree, axis));
  EXPECT_FALSE(beyond.is_within);
  EXPECT_NEAR(beyond.angle, 5.1 * kDegree, 1e-9);
  const auto shifted = [&](double share) {
    const Eigen::Vector3d shift = share * model.diameter * rng.UnitVector();
    return Judge(model, T, Eigen::Translation3d(shift) * T);
  };
  EXPECT_TRUE(shifted(0.049).is_within);
  EXPECT_FALSE(shifted(0.051).is_within);
  EXPECT_NEAR(shifted(0.051).distance, 0.051 * model.diameter, 1e-9);
}

// Whatever of the bundled objects is turned by a few degrees out of its symmetry can be told, so
// that no lax bound of 5 deg comes in by the back door.
TEST(PoseSuccess, TenDegreesAcrossTheLineOfSightAreSeen) {
  for (const std::string& name : GeneratedObjectNames()) {
    SCOPED_TRACE(name);
    const ObjectModel model = Generated(name);
    Rng rng(4);
    const Pose T = Before(model, rng.Rotation());
    const Pose T_turned = Eigen::Translation3d(T * model.center) *
                          Pose(Eigen::AngleAxisd(10.0 * kDegree, Eigen::Vector3d::UnitX())) *
                          Eigen::Translation3d(-(T * model.center)) * T;
    const PoseSuccess success = Judge(model, T, T_turned);
    if (success.angle < 9.0 * kDegree) continue;
    EXPECT_FALSE(success.is_indistinguishable) << success.discrepancy << " " << success.deviation;
  }
}

// The mug stands upright before the camera, its handle along the object's x axis.
class Mug : public ::testing::Test {
 protected:
  [[nodiscard]] Pose HandleTowards(double azimuth) const {
    // z of the object up (-y of the camera); at azimuth 0 the handle is turned to the right.
    Eigen::Matrix3d R;
    R.col(0) = Eigen::Vector3d::UnitX();
    R.col(1) = Eigen::Vector3d::UnitZ();
    R.col(2) = -Eigen::Vector3d::UnitY();
    return Before(model_, Eigen::Quaterniond(R)) *
           TurnedBy(model_, azimuth, Eigen::Vector3d::UnitZ());
  }
  const ObjectModel model_ = Generated("mug");
};

TEST_F(Mug, AHiddenHandleIsExcused) {
  // Behind the body, 12 deg to either side of the line of sight. The center of the surface is off
  // the body's axis, so turns are about the axis here.
  const auto turned = [&](double degrees) {
    return HandleTowards(0.0) *
           Pose(Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitZ()));
  };
  const PoseSuccess success = Judge(model_, turned(78.0), turned(102.0));
  EXPECT_NEAR(success.angle, 24.0 * kDegree, 1e-6);
  EXPECT_FALSE(success.is_within);
  EXPECT_TRUE(success.is_indistinguishable) << success.discrepancy << " " << success.deviation;
  EXPECT_TRUE(success.succeeded());
}

TEST_F(Mug, AVisibleHandleElsewhereIsNot) {
  const auto turned = [&](double degrees) {
    return HandleTowards(0.0) *
           Pose(Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitZ()));
  };
  for (const auto& [truth, estimate] : {std::pair(0.0, 180.0),    // On the other side.
                                        std::pair(0.0, 90.0),     // Said to be hidden.
                                        std::pair(90.0, 0.0),     // Said to be visible.
                                        std::pair(-90.0, -60.0),  // In front of the body.
                                        std::pair(0.0, -20.0)}) {
    SCOPED_TRACE(std::to_string(truth) + " and " + std::to_string(estimate));
    const PoseSuccess success = Judge(model_, turned(truth), turned(estimate));
    EXPECT_FALSE(success.is_indistinguishable) << success.discrepancy << " " << success.deviation;
    EXPECT_FALSE(success.succeeded());
  }
}

TEST_F(Mug, WhatHidesTheHandleExcusesIt) {
  const CameraModel camera;
  const Pose T_true = HandleTowards(0.0);
  const Pose T_other = T_true * Pose(Eigen::AngleAxisd(90.0 * kDegree, Eigen::Vector3d::UnitZ()));
  DepthImage measured = Measured(model_, T_true, camera);
  EXPECT_FALSE(JudgePose(model_, T_true, T_other, measured, camera).succeeded());
  // Something nearer, from the body's right edge on.
  const Eigen::Vector2d axis = camera.Project(T_true * Eigen::Vector3d(0.0, 0.0, 0.05));
  for (int v = 0; v < measured.height; ++v) {
    for (int u = static_cast<int>(axis.x()) + 20; u < measured.width; ++u) measured.at(u, v) = 0.4F;
  }
  EXPECT_TRUE(JudgePose(model_, T_true, T_other, measured, camera).is_indistinguishable);
}

TEST(PoseSuccess, ABoxTurnedByARightAngleIsSeen) {
  const ObjectModel model =
      ModelOf(BeveledBox(Eigen::Vector3d(0.06, 0.08, 0.12), 0.002),
              SymmetryGroup::Dihedral(2, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()));
  Rng rng(6);
  for (int i = 0; i < 10; ++i) {
    const Pose T = Before(model, rng.Rotation());
    for (int i_axis = 0; i_axis < 3; ++i_axis) {
      const Eigen::Vector3d axis = Eigen::Vector3d::Unit(i_axis);
      const PoseSuccess turned = Judge(model, T, T * TurnedBy(model, 90.0 * kDegree, axis));
      EXPECT_NEAR(turned.angle, 90.0 * kDegree, 1e-6);
      EXPECT_FALSE(turned.succeeded()) << turned.discrepancy;
      EXPECT_TRUE(Judge(model, T, T * TurnedBy(model, 180.0 * kDegree, axis)).is_within);
    }
  }
}

TEST(PoseSuccess, OutsideTheImageNothingIsExcused) {
  const ObjectModel model = Generated("bracket");
  const CameraModel camera;
  Rng rng(7);
  const Pose T = Before(model, rng.Rotation());
  const DepthImage measured = Measured(model, T, camera);
  for (const Eigen::Vector3d& shift : {Eigen::Vector3d(5.0, 0.0, 0.0),
                                       Eigen::Vector3d(0.0, 0.0, -3.0),
                                       Eigen::Vector3d(0.0, 0.0, 900.0),
                                       Eigen::Vector3d(1e30, 0.0, 0.0)}) {
    const Pose T_away = Eigen::Translation3d(shift) * T;
    EXPECT_FALSE(JudgePose(model, T, T_away, measured, camera).succeeded()) << shift.transpose();
    EXPECT_FALSE(JudgePose(model, T_away, T, measured, camera).is_indistinguishable);
  }
  const Pose T_away = Eigen::Translation3d(Eigen::Vector3d(0.0, 0.0, -3.0)) * T;
  EXPECT_FALSE(JudgePose(model, T_away, T_away, measured, camera).is_indistinguishable);
}

TEST(PoseSuccess, APoseThatIsNotFiniteFails) {
  const ObjectModel model = Generated("bracket");
  const Pose T = Before(model, Eigen::Quaterniond::Identity());
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Pose T_bad = T;
    T_bad.translation().y() = bad;
    for (const auto& [truth, estimate] : {std::pair(T, T_bad), std::pair(T_bad, T)}) {
      const PoseSuccess success =
          JudgePose(model, truth, estimate, DepthImage(640, 480), CameraModel());
      EXPECT_FALSE(success.succeeded());
      EXPECT_TRUE(std::isnan(success.angle));
      EXPECT_TRUE(std::isnan(success.distance));
    }
  }
}

TEST(PoseSuccess, AnImageOfAnotherSizeIsTheCallersError) {
  const ObjectModel model = Generated("bracket");
  const Pose T = Before(model, Eigen::Quaterniond::Identity());
  EXPECT_DEATH(JudgePose(model, T, T, DepthImage(320, 240), CameraModel()), "camera's size");
}

}  // namespace
}  // namespace vantage
