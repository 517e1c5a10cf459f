#include "common/so3.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Angles where formulas break, and some between.
std::vector<double> Angles() {
  std::vector<double> angles = {0.0, 1e-300, 1e-12, 1e-9, 1e-5, 1e-4, 0.5};
  for (const double below_pi : {0.5, 1e-4, 1e-9, 0.0}) angles.push_back(kPi - below_pi);
  Rng rng(3);
  for (int i = 0; i < 50; ++i) angles.push_back(rng.Uniform(0.0, kPi));
  return angles;
}

TEST(So3, ExpAgreesWithAngleAxis) {
  Rng rng(1);
  for (const double angle : Angles()) {
    const Eigen::Vector3d axis = rng.UnitVector();
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    const Eigen::Quaterniond q = ExpSo3(angle * axis);
    EXPECT_NEAR(q.norm(), 1.0, 1e-15);
    EXPECT_LE((q.toRotationMatrix() - expected).norm(), 1e-14) << "angle " << angle;
  }
}

TEST(So3, LogInvertsExp) {
  Rng rng(2);
  for (const double angle : Angles()) {
    const Eigen::Vector3d vector = angle * rng.UnitVector();
    const Eigen::Vector3d back = LogSo3(ExpSo3(vector));
    // At pi the axis may come back turned round.
    const double error =
        std::min((back - vector).norm(), angle > kPi - 1e-6 ? (back + vector).norm() : 1e9);
    EXPECT_LE(error, 1e-14 + 4e-16 * angle) << "angle " << angle;
    EXPECT_LE(back.norm(), kPi + 1e-15);
  }
}

TEST(So3, LogTakesQAndMinusQAsOne) {
  Rng rng(4);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    EXPECT_LE((LogSo3(q) - LogSo3(Eigen::Quaterniond(-q.coeffs()))).norm(), 1e-14);
  }
}

TEST(So3, ExpOfLogIsTheSameRotation) {
  Rng rng(5);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    EXPECT_LE(GeodesicAngle(ExpSo3(LogSo3(q)), q), 1e-14);
  }
}

TEST(So3, GeodesicAngleIsTheAngleTurned) {
  Rng rng(6);
  for (const double angle : Angles()) {
    const Eigen::Quaterniond a = rng.Rotation();
    const Eigen::Quaterniond b = a * ExpSo3(angle * rng.UnitVector());
    // Relative near 0: acos would lose half the digits there.
    EXPECT_NEAR(GeodesicAngle(a, b), angle, 1e-15 + 4e-15 * angle) << "angle " << angle;
    EXPECT_NEAR(GeodesicAngle(b, a), GeodesicAngle(a, b), 1e-15);
    EXPECT_NEAR(GeodesicAngle(a, Eigen::Quaterniond(-b.coeffs())), GeodesicAngle(a, b), 1e-15);
  }
}

TEST(So3, GeodesicAngleIsInvariantAndTriangular) {
  Rng rng(7);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Quaterniond a = rng.Rotation();
    const Eigen::Quaterniond b = rng.Rotation();
    const Eigen::Quaterniond c = rng.Rotation();
    EXPECT_NEAR(GeodesicAngle(c * a, c * b), GeodesicAngle(a, b), 1e-14);
    EXPECT_NEAR(GeodesicAngle(a * c, b * c), GeodesicAngle(a, b), 1e-14);
    EXPECT_LE(GeodesicAngle(a, c), GeodesicAngle(a, b) + GeodesicAngle(b, c) + 1e-14);
  }
}

TEST(So3, CanonicalPicksOneOfQAndMinusQ) {
  Rng rng(8);
  std::vector<Eigen::Quaterniond> rotations;
  for (int i = 0; i < 100; ++i) rotations.push_back(rng.Rotation());
  rotations.emplace_back(0.0, 0.6, 0.8, 0.0);
  rotations.emplace_back(0.0, -1.0, 0.0, 0.0);
  rotations.emplace_back(0.0, 0.6, 0.0, -0.8);
  for (const Eigen::Quaterniond& q : rotations) {
    const Eigen::Quaterniond canonical = Canonical(q);
    EXPECT_EQ(canonical.coeffs(), Canonical(Eigen::Quaterniond(-q.coeffs())).coeffs());
    EXPECT_EQ(GeodesicAngle(canonical, q), 0.0);
    EXPECT_GE(canonical.w(), 0.0);
  }
}

TEST(QuaternionFromWire, NormalizesAndKeepsOrder) {
  const std::array<double, 4> wxyz = {0.5004, 0.5, -0.5, 0.5};
  const Result<Eigen::Quaterniond> q = QuaternionFromWire(wxyz);
  ASSERT_TRUE(q.ok());
  EXPECT_NEAR(q->norm(), 1.0, 1e-15);
  EXPECT_GT(q->w(), q->x());
  EXPECT_LT(q->y(), 0.0);
}

TEST(QuaternionFromWire, RefusesWhatIsNoRotation) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const std::array<double, 4>& wxyz : {std::array<double, 4>{0.0, 0.0, 0.0, 0.0},
                                            std::array<double, 4>{1.01, 0.0, 0.0, 0.0},
                                            std::array<double, 4>{kNan, 0.0, 0.0, 1.0},
                                            std::array<double, 4>{infinity, 0.0, 0.0, 0.0},
                                            std::array<double, 4>{1e200, 1e200, 0.0, 0.0}}) {
    const Result<Eigen::Quaterniond> q = QuaternionFromWire(wxyz);
    ASSERT_FALSE(q.ok());
    EXPECT_NE(q.error().message.find("expected 1"), std::string::npos) << q.error().message;
  }
}

TEST(PoseFromWire, TakesMetresAndWxyz) {
  const std::array<double, 3> trans = {1.0, -2.0, 3.0};
  const std::array<double, 4> half_turn_z = {0.0, 0.0, 0.0, 1.0};
  const Result<Pose> pose = PoseFromWire(trans, half_turn_z);
  ASSERT_TRUE(pose.ok());
  EXPECT_LE((*pose * Eigen::Vector3d(1.0, 0.0, 0.0) - Eigen::Vector3d(0.0, -2.0, 3.0)).norm(),
            1e-15);
}

TEST(PoseFromWire, RefusesTranslationsThatCannotBe) {
  const std::array<double, 4> identity = {1.0, 0.0, 0.0, 0.0};
  for (const double bad : {kNan, std::numeric_limits<double>::infinity(), 1e7, -1e7}) {
    const std::array<double, 3> trans = {0.0, bad, 0.0};
    EXPECT_FALSE(PoseFromWire(trans, identity).ok()) << bad;
  }
}

TEST(ProjectToRotation, FindsTheNearestRotation) {
  Rng rng(9);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Matrix3d R = rng.Rotation().toRotationMatrix();
    Eigen::Matrix3d noise;
    for (double& value : noise.reshaped()) value = 0.003 * rng.Normal();
    const Eigen::Matrix3d matrix = R + noise;
    const Result<Eigen::Matrix3d> found = ProjectToRotation(matrix);
    ASSERT_TRUE(found.ok());
    EXPECT_LE((*found * found->transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(found->determinant(), 1.0, 1e-14);
    // No rotation near it is nearer to the matrix.
    const double distance = (*found - matrix).norm();
    for (int j = 0; j < 20; ++j) {
      const Eigen::Matrix3d other = *found * ExpSo3(1e-3 * rng.UnitVector()).toRotationMatrix();
      EXPECT_GE((other - matrix).norm(), distance);
    }
  }
}

TEST(ProjectToRotation, RefusesMirrorsScalesAndNan) {
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  EXPECT_FALSE(ProjectToRotation(-identity).ok());
  EXPECT_FALSE(ProjectToRotation(1.2 * identity).ok());
  EXPECT_FALSE(ProjectToRotation(Eigen::Matrix3d::Zero()).ok());
  EXPECT_FALSE(ProjectToRotation(Eigen::Matrix3d::Constant(kNan)).ok());
  EXPECT_TRUE(ProjectToRotation(1.02 * identity).ok());
}

TEST(LookAt, PutsTheTargetOnTheOpticalAxis) {
  Rng rng(10);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d eye = rng.Uniform(0.1, 2.0) * rng.UnitVector();
    const Eigen::Vector3d target = 0.05 * rng.UnitVector();
    const Pose T_world_camera = LookAt(eye, target);
    const Eigen::Vector3d p_camera = T_world_camera.inverse() * target;
    EXPECT_LE((p_camera - Eigen::Vector3d(0.0, 0.0, (target - eye).norm())).norm(), 1e-12);
    EXPECT_NEAR(T_world_camera.linear().determinant(), 1.0, 1e-12);
    // World up is image up: y points down.
    EXPECT_LE(T_world_camera.linear().col(1).z(), 1e-12);
    EXPECT_NEAR(T_world_camera.linear().col(0).z(), 0.0, 1e-12);
  }
}

TEST(LookAt, IsARotationWhenUpIsAlongTheView) {
  const Pose T_world_camera = LookAt({0.0, 0.0, 1.0}, {0.0, 0.0, 0.0});
  EXPECT_LE(
      (T_world_camera.linear() * T_world_camera.linear().transpose() - Eigen::Matrix3d::Identity())
          .norm(),
      1e-14);
  EXPECT_LE((T_world_camera.linear().col(2) + Eigen::Vector3d::UnitZ()).norm(), 1e-14);
}

}  // namespace
}  // namespace vantage
