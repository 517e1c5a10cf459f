#include "perception/calibration/target_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "rendered_target.h"

namespace vantage {
namespace {

using Kind = CalibrationTarget::Kind;

const CameraModel kCamera{
    .width = 480, .height = 360, .fx = 450.0, .fy = 450.0, .cx = 239.5, .cy = 179.5};

const CalibrationTarget kGrid{.columns = 4, .rows = 3};
const CalibrationTarget kTag{.columns = 1, .rows = 1, .size = 0.08, .first_id = 7};
const CalibrationTarget kLargeTags{
    .columns = 2, .rows = 1, .size = 0.03, .gap = 0.04, .family = "tagStandard41h12"};
const CalibrationTarget kChessboard{
    .kind = Kind::kChessboard, .columns = 6, .rows = 5, .size = 0.024};
const CalibrationTarget kCharuco{.kind = Kind::kCharuco,
                                 .columns = 5,
                                 .rows = 4,
                                 .size = 0.04,
                                 .marker = 0.03,
                                 .first_id = 3,
                                 .family = "DICT_5X5_50"};

Pose PoseBefore(double roll, const Eigen::Vector3d& tilt) {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3(tilt).toRotationMatrix() *
                  Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(0.004, -0.007, 0.36);
  return pose;
}

struct Errors {
  size_t count = 0;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();  ///< px
  double rms = 0.0;                                ///< px, per axis
  double largest = 0.0;                            ///< px
};

/// Of what a detector finds in pictures of a target turned in three ways.
Errors Measure(const CalibrationTarget& target, const ImageFlaws& flaws) {
  Rng rng(3);
  auto detector = MakeTargetDetector(target).value();
  Errors errors;
  for (int i = 0; i < 3; ++i) {
    const Pose T_camera_target = PoseBefore(0.1 + 2.0 * i, 0.5 * rng.UnitVector());
    const GrayImage image = RenderTarget(target, kCamera, T_camera_target, flaws, rng);
    for (const TargetPoint& point : detector->Detect(image)) {
      const Eigen::Vector2d error = point.pixel - kCamera.Project(T_camera_target * point.p_target);
      errors.bias += error;
      errors.rms += 0.5 * error.squaredNorm();
      errors.largest = std::max(errors.largest, error.norm());
      ++errors.count;
    }
  }
  errors.bias /= static_cast<double>(std::max<size_t>(errors.count, 1));
  errors.rms = std::sqrt(errors.rms / static_cast<double>(std::max<size_t>(errors.count, 1)));
  return errors;
}

TEST(TargetDetector, FindsPointsWhereTheyAreWithoutBias) {
  for (const CalibrationTarget& target : {kGrid, kTag, kLargeTags, kChessboard, kCharuco}) {
    for (const ImageFlaws& flaws : {ImageFlaws{}, ImageFlaws{.blur = 1, .noise = 3.0}}) {
      SCOPED_TRACE(target.family + (target.kind == Kind::kChessboard ? " chessboard" : ""));
      const Errors errors = Measure(target, flaws);
      const size_t all = 3 * TargetPoints(target).size();
      EXPECT_LE(errors.count, all);
      EXPECT_GE(errors.count, all * 9 / 10);
      EXPECT_LT(errors.bias.norm(), 0.05);
      EXPECT_LT(errors.rms, 0.12);
      EXPECT_LT(errors.largest, 0.6);
    }
  }
}

TEST(TargetDetector, OfTagsThoseThatAreSeen) {
  Rng rng(1);
  auto detector = MakeTargetDetector(kGrid).value();
  Pose T_camera_target = PoseBefore(0.0, Eigen::Vector3d::Zero());
  T_camera_target.translation().x() += 0.2;
  const auto points =
      detector->Detect(RenderTarget(kGrid, kCamera, T_camera_target, ImageFlaws{}, rng));
  EXPECT_GT(points.size(), 0U);
  EXPECT_LT(points.size(), TargetPoints(kGrid).size());
  EXPECT_EQ(points.size() % 4, 0U);
}

TEST(TargetDetector, OfAChessboardAllOrNone) {
  Rng rng(1);
  auto detector = MakeTargetDetector(kChessboard).value();
  Pose T_camera_target = PoseBefore(0.0, Eigen::Vector3d::Zero());
  T_camera_target.translation().x() += 0.16;
  EXPECT_TRUE(
      detector->Detect(RenderTarget(kChessboard, kCamera, T_camera_target, ImageFlaws{}, rng))
          .empty());
}

TEST(TargetDetector, OtherTagsAreNoPartOfTheTarget) {
  Rng rng(1);
  const GrayImage image =
      RenderTarget(kGrid, kCamera, PoseBefore(0.0, Eigen::Vector3d::Zero()), ImageFlaws{}, rng);
  CalibrationTarget other = kGrid;
  other.first_id = 100;
  EXPECT_TRUE(MakeTargetDetector(other).value()->Detect(image).empty());
}

TEST(TargetDetector, ATagThatIsThereTwiceIsNone) {
  Rng rng(1);
  GrayImage image =
      RenderTarget(kTag, kCamera, PoseBefore(0.0, Eigen::Vector3d::Zero()), ImageFlaws{}, rng);
  auto detector = MakeTargetDetector(kTag).value();
  ASSERT_EQ(detector->Detect(image).size(), 4U);
  GrayImage twice(2 * image.width, image.height);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < twice.width; ++u) twice.at(u, v) = image.at(u % image.width, v);
  }
  EXPECT_TRUE(detector->Detect(twice).empty());
}

TEST(TargetDetector, TakesAnyImage) {
  Rng rng(5);
  for (const CalibrationTarget& target : {kGrid, kTag, kLargeTags, kChessboard, kCharuco}) {
    auto detector = MakeTargetDetector(target).value();
    for (const auto& [width, height] :
         {std::pair{0, 0}, {0, 5}, {1, 1}, {1, 5000}, {5000, 1}, {16, 16}, {17, 200}, {64, 48}}) {
      GrayImage image(width, height);
      EXPECT_TRUE(detector->Detect(image).empty());
      for (uint8_t& pixel : image.pixels) pixel = static_cast<uint8_t>(rng.Below(256));
      EXPECT_TRUE(detector->Detect(image).empty());
    }
    // Sizes that the pixels don't bear out.
    GrayImage lying(64, 48);
    lying.width = 1 << 30;
    EXPECT_TRUE(detector->Detect(lying).empty());
    lying.width = -64;
    EXPECT_TRUE(detector->Detect(lying).empty());
    lying.width = 64;
    lying.pixels.resize(10);
    EXPECT_TRUE(detector->Detect(lying).empty());
  }
}

TEST(TargetDetector, NoneForABadTarget) {
  EXPECT_FALSE(MakeTargetDetector({.columns = 0}).ok());
  EXPECT_FALSE(MakeTargetDetector({.family = "no such family"}).ok());
  EXPECT_FALSE(MakeTargetDetector({.kind = Kind::kChessboard, .columns = 8, .rows = 6}).ok());
}

}  // namespace
}  // namespace vantage
