#include "nodes/handeye_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>

#include "common/rng.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

Pose RandomPose(Rng& rng) {
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
  return pose;
}

HandEyeCovariance RandomCovariance(Rng& rng) {
  HandEyeCovariance root;
  for (double& value : root.reshaped()) value = 1e-3 * rng.Normal();
  const HandEyeCovariance product = root * root.transpose();
  return 0.5 * (product + product.transpose());
}

HandEyeFile Made() {
  Rng rng(4);
  HandEyeFile file;
  file.camera = "FRONT";
  file.setup = HandEyeSetup::kEyeToHand;
  file.created_utime = 1'700'000'000'000'000;
  file.T_x = RandomPose(rng);
  file.T_y = RandomPose(rng);
  file.covariance = RandomCovariance(rng);
  file.target_covariance = RandomCovariance(rng);
  file.cross_covariance = 0.1 * RandomCovariance(rng);
  file.squared_radius_95 = 13.1;
  file.noise_scale = 1.7;
  file.num_views = 28;
  file.num_outliers = 2;
  file.rotation_rms = 0.0012345;
  file.translation_rms = 0.00071;
  file.pixel_rms = 0.31;
  file.robot_scale = 1.0003;
  file.time_offset = -0.0123;
  file.intrinsics =
      CameraModel{.width = 640, .height = 480, .fx = 571.3, .fy = 570.0, .cx = 318.2, .cy = 243.0};
  file.distortion = {.k1 = 0.01, .k2 = -0.03, .p1 = 1e-4, .p2 = -2e-4, .k3 = 0.005};
  return file;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string Refusal(const std::string& text) {
  const Result<HandEyeFile> read = ParseHandEyeFile(text, "handeye.toml");
  return read ? "" : read.error().message;
}

TEST(HandEyeFile, ReadsBackWhatItWrote) {
  HandEyeFile file = Made();
  for (const bool has_intrinsics : {true, false}) {
    if (!has_intrinsics) {
      file.intrinsics.reset();
      file.distortion = {};
    }
    const Result<HandEyeFile> read = ParseHandEyeFile(HandEyeFileText(file), "handeye.toml");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->camera, file.camera);
    EXPECT_EQ(read->setup, file.setup);
    EXPECT_EQ(read->created_utime, file.created_utime);
    EXPECT_TRUE(read->T_x.isApprox(file.T_x, 1e-14));
    EXPECT_TRUE(read->T_y.isApprox(file.T_y, 1e-14));
    EXPECT_EQ(read->covariance, file.covariance);
    EXPECT_EQ(read->target_covariance, file.target_covariance);
    EXPECT_EQ(read->cross_covariance, file.cross_covariance);
    EXPECT_EQ(read->squared_radius_95, file.squared_radius_95);
    EXPECT_EQ(read->noise_scale, file.noise_scale);
    EXPECT_EQ(read->num_views, file.num_views);
    EXPECT_EQ(read->num_outliers, file.num_outliers);
    EXPECT_EQ(read->rotation_rms, file.rotation_rms);
    EXPECT_EQ(read->translation_rms, file.translation_rms);
    EXPECT_EQ(read->pixel_rms, file.pixel_rms);
    EXPECT_EQ(read->robot_scale, file.robot_scale);
    EXPECT_EQ(read->time_offset, file.time_offset);
    EXPECT_EQ(read->intrinsics, file.intrinsics);
    EXPECT_EQ(read->distortion, file.distortion);
    EXPECT_EQ(HandEyeFileText(file), HandEyeFileText(file));
  }
}

TEST(HandEyeFile, WhatIsWrongIsNamed) {
  const std::string text = HandEyeFileText(Made());
  const auto expect =
      [&](const std::string& from, const std::string& to, const std::string& words) {
        const std::string refusal = Refusal(Replaced(text, from, to));
        EXPECT_NE(refusal.find("handeye.toml"), std::string::npos) << words << ": " << refusal;
        EXPECT_NE(refusal.find(words), std::string::npos) << words << ": " << refusal;
      };
  EXPECT_EQ(Refusal(text), "");
  expect("setup = \"eye-to-hand\"", "setup = \"eye-on-hand\"", "expected one of \"eye-in-hand\"");
  expect("setup =", "set_up =", "unknown key");
  expect("camera = \"FRONT\"", "", "camera: missing");
  expect("\"FRONT\"", "\"../front\"", "the <NAME> of its channels");
  expect("\"FRONT\"", "\"\"", "the <NAME> of its channels");
  expect("noise_scale = 1.7", "noise_scale = nan", "fit.noise_scale");
  expect("noise_scale = 1.7", "noise_scale = -1.7", "expected a number from 0");
  expect("squared_radius_95 = 13.1", "", "fit.squared_radius_95: missing");
  expect("num_views = 28", "num_views = 2", "fit.num_views = 2: expected a number from 3");
  expect("scale = 1.0003", "scale = 0.0", "robot.scale");
  expect("time_offset_s = -0.0123", "time_offset_s = inf", "robot.time_offset_s");
  expect("fx_px = 571.3", "fx_px = 0.0", "intrinsics.fx_px");
  expect("width_px = 640", "width_px = 640000", "intrinsics.width_px");
  expect("width_px = 640\n", "", "intrinsics.width_px: missing");
  expect("position_m = [", "position_m = [1.0, ", "camera_pose.position_m");
  expect("position_m = [", "position_m = [1e9, ", "camera_pose.position_m");
  expect("quaternion_wxyz = [", "quaternion_wxyz = [1.0, 1.0, 0.0, 0.0] # ", "norm 1.41");
  expect("created_utime_us = 17", "created_utime_us = -17", "created_utime_us");
}

TEST(HandEyeFile, WhatIsNoCovarianceIsNamed) {
  HandEyeFile file = Made();
  file.covariance(0, 1) += 1e-6;
  EXPECT_NE(Refusal(HandEyeFileText(file)).find("camera_pose.covariance"), std::string::npos);
  file = Made();
  file.target_covariance(2, 2) *= -1.0;
  EXPECT_NE(Refusal(HandEyeFileText(file)).find("target_pose.covariance"), std::string::npos);
  file = Made();
  file.covariance.setIdentity();
  file.covariance(0, 1) = file.covariance(1, 0) = 1.5;
  EXPECT_NE(Refusal(HandEyeFileText(file)).find("negative eigenvalues"), std::string::npos);
  file.covariance.setZero();
  EXPECT_EQ(Refusal(HandEyeFileText(file)), "");
}

// No prefix of a file passes for a file, but for one that ends with its last lines.
TEST(HandEyeFile, WhatIsCutOffIsRefused) {
  HandEyeFile file = Made();
  const std::string text = HandEyeFileText(file);
  const size_t last_table = text.find("\n[robot]");
  ASSERT_NE(last_table, std::string::npos);
  const size_t fit = text.find("num_views");
  for (size_t size = 0; size < fit; size += 7) {
    EXPECT_NE(Refusal(text.substr(0, size)), "") << size;
  }
}

TEST(HandEyeFile, IsWrittenWholeOrNotAtAll) {
  const fs::path folder =
      fs::temp_directory_path() / ("vantage-handeye-file-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const fs::path file = folder / "handeye.toml";
  ASSERT_TRUE(WriteHandEyeFile(Made(), file).ok());
  const Result<HandEyeFile> read = ReadHandEyeFile(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(read->T_x.isApprox(Made().T_x, 1e-14));
  EXPECT_FALSE(fs::exists(folder / "handeye.toml.part"));
  EXPECT_FALSE(WriteHandEyeFile(Made(), folder / "no" / "handeye.toml").ok());
  fs::create_directories(folder / "taken" / "x");
  EXPECT_FALSE(WriteHandEyeFile(Made(), folder / "taken").ok());
  EXPECT_FALSE(fs::exists(folder / "taken.part"));
  EXPECT_NE(ReadHandEyeFile(folder / "none.toml").error().message.find("none.toml is not there"),
            std::string::npos);
  ASSERT_TRUE(WriteFileBytes(file, "camera = [[[[").ok());
  EXPECT_NE(ReadHandEyeFile(file).error().message.find("handeye.toml:1"), std::string::npos);
  fs::remove_all(folder);
}

HandEyeResult SomeResult() {
  Rng rng(6);
  HandEyeResult result;
  result.T_x = RandomPose(rng);
  result.T_y = RandomPose(rng);
  result.covariance = RandomCovariance(rng);
  result.views = {{.name = "a", .pixels = 3.0},
                  {.name = "b", .pixels = 4.0},
                  {.name = "c", .pixels = 100.0, .is_outlier = true}};
  result.time_offset = 0.02;
  result.observability.reason = "add views";
  return result;
}

TEST(HandEyeFile, OutliersDoNotCount) {
  const HandEyeFile file = MakeHandEyeFile(SomeResult(), "FRONT", 5);
  EXPECT_EQ(file.num_views, 2);
  EXPECT_EQ(file.num_outliers, 1);
  EXPECT_NEAR(file.pixel_rms, std::sqrt(12.5), 1e-12);
  EXPECT_EQ(file.robot_scale, 1.0);
  EXPECT_EQ(file.time_offset, 0.02);
}

}  // namespace
}  // namespace vantage
