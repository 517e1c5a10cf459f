#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "perception/calibration/image_calibration.h"
#include "perception/calibration/target_detector.h"
#include "rendered_target.h"
#include "simulated_image_views.h"

// From pictures of a board to the camera's place, without a point that is made up.
namespace vantage {
namespace {

void ExpectCalibrated(const SimulatedImageRequest& request) {
  Rng rng(21);
  SimulatedImageViews made = SimulateImageViews(request, rng);
  auto detector = MakeTargetDetector(request.target).value();
  for (size_t i = 0; i < made.views.size(); ++i) {
    const GrayImage image = RenderTarget(
        request.target, request.camera, made.T_camera_target[i], {.blur = 1, .noise = 2.0}, rng);
    made.views[i].points = detector->Detect(image);
    EXPECT_GE(made.views[i].points.size(), TargetPoints(request.target).size() * 3 / 4);
  }
  const auto result = CalibrateFromImages(request.setup, made.views, request.camera, {}, {});
  ASSERT_TRUE(result.ok()) << result.error().message;
  const auto error = PoseError(result->T_x, made.T_x);
  EXPECT_LT(error.tail<3>().norm(), 0.0004);
  EXPECT_LT(error.head<3>().norm(), 0.1 * kDegree);
  EXPECT_LT(error.dot(result->covariance.ldlt().solve(error)), 2.0 * result->squared_radius_95);
  for (const ViewResidual& view : result->views) EXPECT_FALSE(view.is_outlier) << view.name;
}

const CameraModel kCamera{
    .width = 480, .height = 360, .fx = 450.0, .fy = 450.0, .cx = 239.5, .cy = 179.5};

TEST(ImageCalibrationRendered, EyeInHandWithTags) {
  ExpectCalibrated({.setup = HandEyeSetup::kEyeInHand,
                    .target = {.columns = 4, .rows = 3},
                    .views = 10,
                    .distance = 0.36,
                    .camera = kCamera});
}

TEST(ImageCalibrationRendered, EyeToHandWithAChessboard) {
  ExpectCalibrated({.setup = HandEyeSetup::kEyeToHand,
                    .target = {.kind = CalibrationTarget::Kind::kChessboard,
                               .columns = 6,
                               .rows = 5,
                               .size = 0.024},
                    .views = 10,
                    .distance = 0.36,
                    .camera = kCamera});
}

}  // namespace
}  // namespace vantage
