#include "drivers/camera/rectification.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vantage {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;
const CameraIntrinsics kDepth{
    {.width = kWidth, .height = kHeight, .fx = 40.0, .fy = 40.0, .cx = 19.5, .cy = 14.5}, {}};
const CameraIntrinsics kColor{
    {.width = 80, .height = 60, .fx = 78.0, .fy = 78.0, .cx = 39.5, .cy = 29.5}, {}};
const LensDistortion kLens{.k1 = 0.3};

class RectificationTest : public testing::Test {
 protected:
  RectificationTest() {
    details_.width = kWidth;
    details_.height = kHeight;
    details_.horizontal_fov = 1.0;
    details_.vertical_fov = 0.8;
    details_.has_color = true;
    request_.color = true;
  }
  void Calibrate() {
    calibration_.emplace().intrinsics = kDepth;
    calibration_->color = kColor;
    calibration_->T_color_depth = Pose(Eigen::Translation3d(0.03, 0.0, 0.0));
  }
  [[nodiscard]] std::string Note() const {
    const auto made = Rectification::Create(details_, request_, calibration_);
    return made.ok() ? made->note() : "error: " + made.error().message;
  }
  // Depth of 1 m with color of gray value 80, RGB.
  [[nodiscard]] CameraFrame MakeFrame(int color_width = 80, int color_height = 60) const {
    CameraFrame frame;
    if (details_.has_depth) frame.depth_mm.assign(kWidth * kHeight, 1000);
    ColorImage& color = frame.color.emplace();
    color.layout = request_.color_layout;
    color.width = color_width;
    color.height = color_height;
    color.data.assign(static_cast<size_t>(3 * color_width * color_height), 80);
    return frame;
  }
  CameraFrame Apply(CameraFrame frame) {
    auto made = Rectification::Create(details_, request_, calibration_);
    EXPECT_TRUE(made.ok()) << made.error().message;
    fault_ = made->Apply(&frame);
    return frame;
  }

  StreamDetails details_;
  StreamRequest request_;
  std::optional<CameraCalibration> calibration_;
  std::string fault_;
};

TEST_F(RectificationTest, WithoutCalibrationImagesStayAsTheyAre) {
  const CameraFrame frame = Apply(MakeFrame());
  EXPECT_EQ(fault_, "");
  EXPECT_EQ(Note(), "");
  EXPECT_EQ(frame.width, kWidth);
  EXPECT_NEAR(frame.model->fx, 20.0 / std::tan(0.5), 1e-9);
  EXPECT_FALSE(frame.registered);
  EXPECT_EQ(frame.depth_mm, MakeFrame().depth_mm);
  EXPECT_EQ(frame.color->data, MakeFrame().color->data);
}

TEST_F(RectificationTest, DepthIsRegisteredToColorWhereTheDeviceCanNot) {
  Calibrate();
  request_.registration = Registration::kDepthToColor;
  const CameraFrame frame = Apply(MakeFrame());
  EXPECT_EQ(fault_, "");
  EXPECT_EQ(Note(), "");
  EXPECT_TRUE(frame.registered);
  EXPECT_EQ(frame.model, kColor.camera);
  EXPECT_EQ(frame.width, 80);
  EXPECT_EQ(frame.height, 60);
  ASSERT_EQ(frame.depth_mm.size(), 80U * 60U);
  EXPECT_EQ(frame.depth_mm[30 * 80 + 40], 1000);
  EXPECT_EQ(frame.depth_mm[30 * 80], 0);  // Left of all that was measured.

  // Also while color is missing.
  CameraFrame alone = MakeFrame();
  alone.color.reset();
  EXPECT_EQ(Apply(alone).depth_mm, frame.depth_mm);
}

TEST_F(RectificationTest, ADeviceThatRegistersHasTheColorCamerasIntrinsics) {
  Calibrate();
  request_.registration = Registration::kDepthToColor;
  details_.registered = true;
  EXPECT_NE(Note().find("expected the 80 x 60 px of the calibration"), std::string::npos);
  calibration_->color->camera = kDepth.camera;
  calibration_->color->camera.fx = 41.0;
  const CameraFrame frame = Apply(MakeFrame(kWidth, kHeight));
  EXPECT_TRUE(frame.registered);
  EXPECT_EQ(frame.model->fx, 41.0);
  EXPECT_EQ(frame.depth_mm, MakeFrame().depth_mm);
}

TEST_F(RectificationTest, ColorIsRegisteredToDepth) {
  Calibrate();
  request_.registration = Registration::kColorToDepth;
  const CameraFrame frame = Apply(MakeFrame());
  EXPECT_EQ(Note(), "");
  EXPECT_TRUE(frame.registered);
  EXPECT_EQ(frame.model, kDepth.camera);
  EXPECT_EQ(frame.color->width, kWidth);
  EXPECT_EQ(frame.color->height, kHeight);
  ASSERT_EQ(frame.color->data.size(), 3U * kWidth * kHeight);
  EXPECT_EQ(frame.color->data[3 * (15 * kWidth + 20)], 80);
}

TEST_F(RectificationTest, SaysWhatARegistrationLacks) {
  request_.registration = Registration::kDepthToColor;
  EXPECT_EQ(
      Note(),
      "it can't register depth to color, and there is no calibration file to calculate it by");
  Calibrate();
  calibration_->T_color_depth.reset();
  EXPECT_EQ(Note(),
            "it can't register depth to color, and the calibration file has no [color_from_depth]");
  calibration_->color.reset();
  EXPECT_EQ(Note(), "it can't register depth to color, and the calibration file has no [color]");
  EXPECT_FALSE(Apply(MakeFrame()).registered);
  request_.registration = Registration::kColorToDepth;
  EXPECT_EQ(Note(), "it can't register color to depth, and the calibration file has no [color]");
  Calibrate();
  request_.color_layout = PixelLayout::kJpeg;
  EXPECT_EQ(Note(), "JPEG images can't be registered to depth, expected RGB or gray ones");
  details_.has_color = false;
  EXPECT_EQ(Note(), "it gives no color, so color to depth can't be registered");
  details_.has_depth = false;
  EXPECT_EQ(Note(), "it gives no depth, so color to depth can't be registered");
}

TEST_F(RectificationTest, ColorOfAnotherSizeThanTheCalibratedOneIsAFault) {
  Calibrate();
  Apply(MakeFrame(40, 30));
  EXPECT_EQ(fault_, "color frame of 40 x 30 px, expected the 80 x 60 px of the calibration");
}

TEST_F(RectificationTest, DistortionIsTakenOutOfColorToo) {
  details_.has_depth = false;
  calibration_.emplace().intrinsics = {kDepth.camera, kLens};
  CameraFrame frame = Apply(MakeFrame(kWidth, kHeight));
  EXPECT_EQ(frame.model, kDepth.camera);
  EXPECT_TRUE(frame.distortion.IsNone());
  EXPECT_EQ(frame.color->data.front(), 0);  // Beside the distorted image.
  EXPECT_EQ(frame.color->data[3 * (15 * kWidth + 20)], 80);

  details_.has_depth = true;
  Calibrate();
  calibration_->color->distortion = kLens;
  frame = Apply(MakeFrame());
  EXPECT_EQ(frame.model, kDepth.camera);
  EXPECT_EQ(frame.color->data.front(), 0);

  // Also where a registration was asked for in vain.
  calibration_->T_color_depth.reset();
  request_.registration = Registration::kColorToDepth;
  EXPECT_EQ(Apply(MakeFrame()).color->data, frame.color->data);
}

TEST_F(RectificationTest, WhatStaysInJpegImagesIsTold) {
  request_.color_layout = PixelLayout::kJpeg;
  Calibrate();
  calibration_->color->distortion = kLens;
  request_.registration = Registration::kDepthToColor;
  EXPECT_EQ(Note(), "color comes as JPEG images, so its distortion stays in it");
  CameraFrame frame = Apply(MakeFrame());
  EXPECT_FALSE(frame.registered);
  EXPECT_TRUE(frame.distortion.IsNone());  // Of the depth.
  EXPECT_EQ(frame.model, kColor.camera);
  EXPECT_EQ(frame.color->data, MakeFrame().color->data);

  request_.registration = Registration::kNone;
  details_.has_depth = false;
  calibration_.emplace().intrinsics = {kDepth.camera, kLens};
  frame = Apply(MakeFrame(kWidth, kHeight));
  EXPECT_EQ(frame.distortion, kLens);
  EXPECT_EQ(Note(), "");
}

}  // namespace
}  // namespace vantage
