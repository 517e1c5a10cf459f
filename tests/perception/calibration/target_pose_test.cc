#include "perception/calibration/target_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "simulated_image_views.h"

namespace vantage {
namespace {

const LensDistortion kLens{.k1 = -0.1, .k2 = 0.05, .p1 = 0.002, .p2 = -0.001, .k3 = 0.01};

TEST(FindTargetPoses, FindsThePoseUnderTheLens) {
  Rng rng(1);
  SimulatedImageRequest request{.views = 50, .noise = {.pixel = 0.0}, .distortion = kLens};
  const SimulatedImageViews made = SimulateImageViews(request, rng);
  for (size_t i = 0; i < made.views.size(); ++i) {
    const auto poses = FindTargetPoses(made.views[i].points, request.camera, kLens, 0.2);
    ASSERT_TRUE(poses.ok());
    const auto error = PoseError((*poses)[0].T_camera_target, made.T_camera_target[i]);
    EXPECT_LT(error.norm(), 1e-7);
    EXPECT_LT((*poses)[0].pixel_rms, 1e-6);
  }
}

TEST(FindTargetPoses, CovarianceIsThatOfTheError) {
  Rng rng(2);
  const double sigma = 0.3;
  const SimulatedImageRequest request{
      .target = {.columns = 2, .rows = 2}, .views = 400, .noise = {.pixel = sigma}};
  const SimulatedImageViews made = SimulateImageViews(request, rng);
  double sum = 0.0;
  for (size_t i = 0; i < made.views.size(); ++i) {
    const auto poses = FindTargetPoses(made.views[i].points, request.camera, {}, sigma);
    ASSERT_TRUE(poses.ok());
    const auto error = PoseError((*poses)[0].T_camera_target, made.T_camera_target[i]);
    sum += error.dot((*poses)[0].covariance.ldlt().solve(error));
  }
  // Chi-square of 6 degrees of freedom; the mean of 400 has a standard deviation of 0.17.
  EXPECT_NEAR(sum / 400.0, 6.0, 0.7);
}

TEST(FindTargetPoses, TheTrueOneOfTwoIsAmongThoseTold) {
  Rng rng(3);
  const SimulatedImageRequest request{.target = {.columns = 1, .rows = 1, .size = 0.05},
                                      .views = 500,
                                      .distance = 0.8,
                                      .tilt = 0.3,
                                      .noise = {.pixel = 0.4}};
  const SimulatedImageViews made = SimulateImageViews(request, rng);
  int wrong_first = 0;
  int missed = 0;
  for (size_t i = 0; i < made.views.size(); ++i) {
    const auto poses = FindTargetPoses(made.views[i].points, request.camera, {}, 0.4);
    ASSERT_TRUE(poses.ok());
    ASSERT_LE(poses->size(), 2U);
    const auto squared = [&](size_t k) {
      const auto error = PoseError((*poses)[k].T_camera_target, made.T_camera_target[i]);
      return error.dot((*poses)[k].covariance.ldlt().solve(error));
    };
    const bool is_first_good = squared(0) < 50.0;
    wrong_first += is_first_good ? 0 : 1;
    missed += is_first_good || (poses->size() == 2 && squared(1) < 50.0) ? 0 : 1;
  }
  EXPECT_GT(wrong_first, 20);  // So the question is a real one,
  EXPECT_LE(missed, 5);        // and it is left open.
}

TEST(FindTargetPoses, OneWhereTheImageTells) {
  Rng rng(4);
  const SimulatedImageRequest request{.views = 50, .noise = {.pixel = 0.2}};
  for (const ImageView& view : SimulateImageViews(request, rng).views) {
    const auto poses = FindTargetPoses(view.points, request.camera, {}, 0.2);
    ASSERT_TRUE(poses.ok());
    EXPECT_EQ(poses->size(), 1U);
  }
}

TEST(FindTargetPoses, NamesWhatIsWrong) {
  Rng rng(5);
  const SimulatedImageRequest request{.views = 1};
  const std::vector<TargetPoint> good = SimulateImageViews(request, rng).views[0].points;
  const auto error = [&](const std::vector<TargetPoint>& points, double sigma = 0.2) {
    const auto poses = FindTargetPoses(points, request.camera, {}, sigma);
    return poses.ok() ? std::string() : poses.error().message;
  };
  EXPECT_EQ(error(good), "");
  EXPECT_NE(error({}).find("0 points"), std::string::npos);
  EXPECT_NE(error({good[0], good[1], good[2]}).find("3 points"), std::string::npos);
  EXPECT_NE(error({good[0], good[1], good[4], good[5]}).find("in a line"), std::string::npos);
  EXPECT_NE(error({good[0], good[0], good[0], good[0]}).find("in a line"), std::string::npos);
  EXPECT_NE(error(good, 0.0).find("noise"), std::string::npos);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    std::vector<TargetPoint> points = good;
    points[3].pixel.x() = bad;
    EXPECT_NE(error(points).find("expected finite numbers"), std::string::npos);
    points = good;
    points[3].p_target.y() = bad;
    EXPECT_NE(error(points).find("expected finite numbers"), std::string::npos);
  }
  std::vector<TargetPoint> same_pixel = good;
  for (TargetPoint& point : same_pixel) point.pixel = Eigen::Vector2d(100.0, 100.0);
  error(same_pixel);  // Any answer; no crash.
  CameraModel camera = request.camera;
  camera.fx = 0.0;
  EXPECT_FALSE(FindTargetPoses(good, camera, {}, 0.2).ok());
}

}  // namespace
}  // namespace vantage
