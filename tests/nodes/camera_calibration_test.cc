#include "nodes/camera_calibration.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/format.h"

namespace vantage {
namespace {

const std::string kDepth =
    "width_px = 640\nheight_px = 480\nfx_px = 570.0\nfy_px = 571.0\ncx_px = 319.0\ncy_px = 240.0\n";
const std::string kDistortion =
    "distortion_model = \"brown_conrady\"\ndistortion = [0.1, -0.2, 0.0, 0.001, 0.0]\n";
const std::string kColor =
    "[color]\nwidth_px = 1280\nheight_px = 960\nfx_px = 1050.0\nfy_px = 1051.0\ncx_px = 639.0\n"
    "cy_px = 480.0\n";
const std::string kPose =
    "[color_from_depth]\nposition_m = [-0.025, 0.0, 0.001]\nrpy_deg = [0.0, 0.0, 90.0]\n";

Result<CameraCalibration> Load(const std::string& text) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) /
                                     Format("camera_calibration_test.%d.toml", getpid());
  std::ofstream(file) << text;
  Result<CameraCalibration> calibration = LoadCameraCalibration(file);
  std::filesystem::remove(file);
  return calibration;
}

TEST(CameraCalibration, IsReadWithItsDistortion) {
  const Result<CameraCalibration> calibration = Load(kDepth + kDistortion);
  ASSERT_TRUE(calibration.ok()) << calibration.error().message;
  EXPECT_EQ(calibration->intrinsics.camera.fy, 571.0);
  EXPECT_EQ(calibration->intrinsics.distortion, (LensDistortion{0.1, -0.2, 0.0, 0.001, 0.0}));
  EXPECT_FALSE(calibration->color.has_value());
  EXPECT_FALSE(calibration->T_color_depth.has_value());
  EXPECT_TRUE(calibration->id.ends_with("#" + calibration->id.substr(calibration->id.size() - 16)));
}

TEST(CameraCalibration, KnowsTheColorCameraAndItsPlace) {
  const Result<CameraCalibration> calibration = Load(kDepth + kColor + kDistortion + kPose);
  ASSERT_TRUE(calibration.ok()) << calibration.error().message;
  EXPECT_TRUE(calibration->intrinsics.distortion.IsNone());
  ASSERT_TRUE(calibration->color.has_value());
  EXPECT_EQ(calibration->color->camera.width, 1280);
  EXPECT_EQ(calibration->color->distortion.k2, -0.2);
  ASSERT_TRUE(calibration->T_color_depth.has_value());
  const Eigen::Vector3d moved = *calibration->T_color_depth * Eigen::Vector3d(1.0, 0.0, 2.0);
  EXPECT_LT((moved - Eigen::Vector3d(-0.025, 1.0, 2.001)).norm(), 1e-12);

  EXPECT_TRUE(Load(kDepth + kColor).ok());  // To take the distortion out of color.
}

TEST(CameraCalibration, ErrorsNameFileAndKey) {
  const struct {
    std::string text;
    std::string expected;
  } cases[] = {
      {"width_px = 640\n", "height_px"},
      {kDepth + "k1 = 0.5\n", "k1 = 0.5: unknown key"},
      {kDepth + "distortion_model = \"fisheye\"\n", "brown_conrady"},
      {kDepth + "distortion_model = \"brown_conrady\"\n", "distortion"},
      {kDepth + "distortion = [0, 0, 0, 0, 0]\n", "distortion"},
      {"no toml", "no valid TOML"},
      {"color = 3\n" + kDepth, "expected a table [color]"},
      {kDepth + "[color]\nwidth_px = 640\n", "color.height_px"},
      {kDepth + kColor + "fps = 30\n", "color.fps"},
      {kDepth + kPose, "color_from_depth"},
      {kDepth + kColor + "[color_from_depth]\nrpy_deg = [0, 0, 0]\n", "position_m"},
      {kDepth + kColor + "[color_from_depth]\nposition_m = [0, 0, 0]\n",
       "expected rpy_deg or quaternion_wxyz"},
      {kDepth + kColor + "[color_from_depth]\nposition_m = [25, 0, 0]\nrpy_deg = [0, 0, 0]\n",
       "expected 1 m at most between two cameras of a device"},
      {kDepth + kColor + "[color_from_depth]\nposition_m = [nan, 0, 0]\nrpy_deg = [0, 0, 0]\n",
       "position_m"},
      {kDepth + kColor +
           "[color_from_depth]\nposition_m = [0, 0, 0]\nquaternion_wxyz = [0, 0, 0, 0]\n",
       "quaternion_wxyz"},
  };
  for (const auto& each : cases) {
    const Result<CameraCalibration> calibration = Load(each.text);
    ASSERT_FALSE(calibration.ok()) << each.text;
    EXPECT_NE(calibration.error().message.find("camera_calibration_test."), std::string::npos);
    EXPECT_NE(calibration.error().message.find(each.expected), std::string::npos)
        << calibration.error().message;
  }
  const Result<CameraCalibration> absent = LoadCameraCalibration("/no/such.toml");
  ASSERT_FALSE(absent.ok());
  EXPECT_NE(absent.error().message.find("/no/such.toml is not there"), std::string::npos);
}

}  // namespace
}  // namespace vantage
