#include "nodes/camera_calibration.h"

#include <string>
#include <vector>

#include "bus/image_conversion.h"
#include "common/format.h"
#include "nodes/config_reader.h"

namespace vantage {
namespace {

CameraIntrinsics ReadIntrinsics(ConfigReader::Table& table) {
  CameraIntrinsics intrinsics;
  CameraModel& model = intrinsics.camera;
  for (const char* key : {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px"}) {
    table.Require(key);
  }
  table.Read("width_px", &model.width, 1, kMaxImageSide);
  table.Read("height_px", &model.height, 1, kMaxImageSide);
  constexpr double kLongest = 1e6;  // px
  table.Read("fx_px", &model.fx, 1.0, kLongest);
  table.Read("fy_px", &model.fy, 1.0, kLongest);
  table.Read("cx_px", &model.cx, -kLongest, kLongest);
  table.Read("cy_px", &model.cy, -kLongest, kLongest);
  std::string distortion_model = "none";
  std::vector<double> k(5, 0.0);
  table.ReadChoice("distortion_model", &distortion_model, {"none", "brown_conrady"});
  table.ReadNumbers("distortion", 5, -100.0, 100.0, &k);
  if (distortion_model == "brown_conrady") {
    table.Require("distortion");
  } else if (table.Has("distortion")) {
    table.Fail("distortion", "expected distortion_model = \"brown_conrady\" beside it");
  }
  intrinsics.distortion = {.k1 = k[0], .k2 = k[1], .p1 = k[2], .p2 = k[3], .k3 = k[4]};
  return intrinsics;
}

Pose ReadColorFromDepth(ConfigReader::Table table) {
  constexpr double kFarthest = 1.0;  // m; more is in another unit.
  Pose T_color_depth = Pose::Identity();
  table.Require("position_m");
  table.ReadPose(&T_color_depth);
  if (!table.Has("quaternion_wxyz") && !table.Has("rpy_deg")) {
    table.Fail("rpy_deg", "expected rpy_deg or quaternion_wxyz beside position_m");
  }
  if (!(T_color_depth.translation().norm() <= kFarthest)) {
    table.Fail("position_m",
               Format("expected %g m at most between two cameras of a device", kFarthest));
  }
  return T_color_depth;
}

}  // namespace

Result<CameraCalibration> LoadCameraCalibration(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("calibration file %s is not there, expected a TOML file with width_px, "
                        "height_px, fx_px, fy_px, cx_px, cy_px",
                        file.c_str())};
  }
  Result<ConfigReader> reader = ConfigReader::Open(file);
  if (!reader) return reader.error();
  CameraCalibration calibration;
  ConfigReader::Table root = reader->Root();
  calibration.intrinsics = ReadIntrinsics(root);
  if (root.Has("color")) {
    ConfigReader::Table color = root.Sub("color");
    calibration.color = ReadIntrinsics(color);
  }
  if (root.Has("color_from_depth")) {
    if (!calibration.color) {
      root.Fail("color_from_depth", "expected [color], the intrinsics of the color camera, too");
    }
    calibration.T_color_depth = ReadColorFromDepth(root.Sub("color_from_depth"));
  }
  if (Result<void> read = reader->Finish(); !read) return read.error();
  calibration.id = file.filename().string() + "#" + reader->Hash();
  return calibration;
}

}  // namespace vantage
