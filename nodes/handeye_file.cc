#include "nodes/handeye_file.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "common/check.h"
#include "common/format.h"
#include "common/time_range.h"
#include "nodes/config_reader.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

constexpr size_t kLongestName = 32;
constexpr double kLargestVariance = 1e6;  // rad^2, m^2
constexpr int kMostViews = 1'000'000;
constexpr double kMostPixels = 1e6;  // px

bool IsCameraName(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName &&
         std::ranges::all_of(name, [](unsigned char c) {
           return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-';
         });
}

// Shortest text that reads back as the same number, always with a point or an exponent.
std::string Number(double value) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value + 0.0).ptr;
  std::string text(buffer.data(), end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

// "1.0, 2.0, 3.0".
std::string Numbers(std::span<const double> values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += ", ";
    text += Number(value);
  }
  return text;
}

// "[1.0, 2.0, 3.0]".
std::string List(std::span<const double> values) { return Format("[%s]", Numbers(values).c_str()); }

std::string Line(const char* key, const std::string& value, const std::string& comment) {
  return Format(
      "%s = %s%s%s\n", key, value.c_str(), comment.empty() ? "" : "   # ", comment.c_str());
}

std::string MatrixText(const char* key, const HandEyeCovariance& matrix) {
  std::string text = Format("%s = [\n", key);
  for (int row = 0; row < 6; ++row) {
    const Eigen::Matrix<double, 6, 1> values = matrix.row(row).transpose();
    text += Format("  %s,\n", Numbers(std::span<const double>(values.data(), 6)).c_str());
  }
  return text + "]\n";
}

std::string PoseText(const Pose& pose, const HandEyeCovariance& covariance) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q = Canonical(Eigen::Quaterniond(pose.linear()));
  const Eigen::Vector3d sigma = covariance.diagonal().cwiseSqrt().head<3>() / kDegree;
  const Eigen::Vector3d sigma_mm = 1e3 * covariance.diagonal().cwiseSqrt().tail<3>();
  std::string text = Line("position_m", List(std::array{t.x(), t.y(), t.z()}), "");
  text +=
      Line("quaternion_wxyz",
           List(std::array{q.w(), q.x(), q.y(), q.z()}),
           Format("%.4f deg in all", GeodesicAngle(q, Eigen::Quaterniond::Identity()) / kDegree));
  text += "# Of the error: rotation vector (rad), then translation (m), row by row.\n";
  text += Format("# Standard deviations: %.4f %.4f %.4f deg, %.4f %.4f %.4f mm.\n",
                 sigma.x(),
                 sigma.y(),
                 sigma.z(),
                 sigma_mm.x(),
                 sigma_mm.y(),
                 sigma_mm.z());
  return text + MatrixText("covariance", covariance);
}

std::string IntrinsicsText(const CameraModel& camera, const LensDistortion& distortion) {
  std::string text = "\n[intrinsics]   # of the camera, as in a calibration file of the driver\n";
  text += Format("width_px = %d\nheight_px = %d\n", camera.width, camera.height);
  text += Line("fx_px", Number(camera.fx), "") + Line("fy_px", Number(camera.fy), "");
  text += Line("cx_px", Number(camera.cx), "the center of the first pixel is 0");
  text += Line("cy_px", Number(camera.cy), "");
  const std::array coefficients = {
      distortion.k1, distortion.k2, distortion.p1, distortion.p2, distortion.k3};
  return text + Line("distortion", List(coefficients), "k1 k2 p1 p2 k3");
}

bool IsCovariance(const HandEyeCovariance& matrix) {
  const Eigen::Matrix<double, 6, 1> sigma = matrix.diagonal().cwiseMax(0.0).cwiseSqrt();
  if ((matrix.diagonal().array() < 0.0).any()) return false;
  constexpr double kTolerance = 1e-6;  // Of correlations.
  HandEyeCovariance correlation = HandEyeCovariance::Identity();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      const double scale = sigma[i] * sigma[j];
      if (std::abs(matrix(i, j) - matrix(j, i)) > kTolerance * scale) return false;
      if (scale > 0.0) {
        correlation(i, j) = 0.5 * (matrix(i, j) + matrix(j, i)) / scale;
      } else if (matrix(i, j) != 0.0) {
        return false;
      }
    }
  }
  const Eigen::SelfAdjointEigenSolver<HandEyeCovariance> solver(correlation,
                                                                Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() > -kTolerance;
}

HandEyeCovariance ReadMatrix(ConfigReader::Table& table, const char* key) {
  std::vector<double> values(36, 0.0);
  table.ReadNumbers(key, 36, -kLargestVariance, kLargestVariance, &values);
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values.data());
}

void ReadPoseTable(ConfigReader::Table table, Pose* pose, HandEyeCovariance* covariance) {
  for (const char* key : {"position_m", "quaternion_wxyz", "covariance"}) table.Require(key);
  table.ReadPose(pose);
  *covariance = ReadMatrix(table, "covariance");
  if (!IsCovariance(*covariance)) {
    table.Fail("covariance", "expected a symmetric matrix without negative eigenvalues");
  }
}

void ReadFit(ConfigReader::Table table, HandEyeFile* calibration) {
  for (const char* key : {"squared_radius_95", "noise_scale", "num_views"}) table.Require(key);
  table.Read("squared_radius_95", &calibration->squared_radius_95, 1.0, 1e6);
  table.Read("noise_scale", &calibration->noise_scale, 0.0, 1e6);
  table.Read("num_views", &calibration->num_views, 3, kMostViews);
  table.Read("num_outliers", &calibration->num_outliers, 0, kMostViews);
  table.Read("rotation_rms_rad", &calibration->rotation_rms, 0.0, 3.2);
  table.Read("translation_rms_m", &calibration->translation_rms, 0.0, 1000.0);
  table.Read("pixel_rms_px", &calibration->pixel_rms, 0.0, kMostPixels);
}

void ReadIntrinsics(ConfigReader::Table table, HandEyeFile* calibration) {
  constexpr int kMostSide = 16384;  // px, as CameraModel::Validate().
  CameraModel camera;
  for (const char* key : {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px"}) {
    table.Require(key);
  }
  table.Read("width_px", &camera.width, 1, kMostSide);
  table.Read("height_px", &camera.height, 1, kMostSide);
  table.Read("fx_px", &camera.fx, 1.0, kMostPixels);
  table.Read("fy_px", &camera.fy, 1.0, kMostPixels);
  table.Read("cx_px", &camera.cx, -kMostPixels, kMostPixels);
  table.Read("cy_px", &camera.cy, -kMostPixels, kMostPixels);
  std::vector<double> distortion(5, 0.0);
  table.ReadNumbers("distortion", 5, -100.0, 100.0, &distortion);
  calibration->intrinsics = camera;
  calibration->distortion = {
      distortion[0], distortion[1], distortion[2], distortion[3], distortion[4]};
}

Result<HandEyeFile> Read(Result<ConfigReader> reader) {
  if (!reader) return reader.error();
  HandEyeFile calibration;
  ConfigReader::Table root = reader->Root();
  for (const char* key : {"camera", "setup", "camera_pose", "target_pose", "fit"}) {
    root.Require(key);
  }
  root.Read("camera", &calibration.camera);
  if (!IsCameraName(calibration.camera)) {
    root.Fail("camera",
              Format("expected 1 to %zu letters, digits, '_' and '-', the <NAME> of its channels",
                     kLongestName));
  }
  std::string setup = "eye-in-hand";
  root.ReadChoice("setup", &setup, {"eye-in-hand", "eye-to-hand"});
  calibration.setup = setup == "eye-in-hand" ? HandEyeSetup::kEyeInHand : HandEyeSetup::kEyeToHand;
  root.Read("created_utime_us", &calibration.created_utime, int64_t{0}, kLatestUtime);
  ReadPoseTable(root.Sub("camera_pose"), &calibration.T_x, &calibration.covariance);
  ConfigReader::Table target = root.Sub("target_pose");
  ReadPoseTable(target, &calibration.T_y, &calibration.target_covariance);
  calibration.cross_covariance = ReadMatrix(target, "cross_covariance");
  ReadFit(root.Sub("fit"), &calibration);
  ConfigReader::Table robot = root.Sub("robot");
  robot.Read("scale", &calibration.robot_scale, 0.1, 10.0);
  robot.Read("time_offset_s", &calibration.time_offset, -60.0, 60.0);
  if (root.Has("intrinsics")) ReadIntrinsics(root.Sub("intrinsics"), &calibration);
  if (Result<void> read = reader->Finish(); !read) return read.error();
  return calibration;
}

}  // namespace

HandEyeFile MakeHandEyeFile(const HandEyeResult& result, const std::string& camera, int64_t utime) {
  HandEyeFile file;
  file.camera = camera;
  file.setup = result.setup;
  file.created_utime = utime;
  file.T_x = result.T_x;
  file.covariance = result.covariance;
  file.T_y = result.T_y;
  file.target_covariance = result.target_covariance;
  file.cross_covariance = result.cross_covariance;
  file.squared_radius_95 = result.squared_radius_95;
  file.noise_scale = result.noise_scale;
  double squares = 0.0;
  for (const ViewResidual& view : result.views) {
    if (view.is_outlier) {
      ++file.num_outliers;
    } else {
      ++file.num_views;
      squares += view.pixels * view.pixels;
    }
  }
  file.rotation_rms = result.rotation_rms;
  file.translation_rms = result.translation_rms;
  file.pixel_rms = std::sqrt(squares / std::max(1, file.num_views));
  file.robot_scale = result.robot_scale.value_or(1.0);
  file.time_offset = result.time_offset.value_or(0.0);
  file.intrinsics = result.camera;
  file.distortion = result.distortion.value_or(LensDistortion{});
  return file;
}

std::string HandEyeFileText(const HandEyeFile& calibration) {
  const bool in_hand = calibration.setup == HandEyeSetup::kEyeInHand;
  VANTAGE_CHECK(IsCameraName(calibration.camera), calibration.camera);
  std::string text = Format(
      "# Hand-eye calibration of vantage-handeye. Poses map points: p_hand = T_hand_camera "
      "p_camera.\n"
      "camera = \"%s\"\n"
      "setup = \"%s\"   # the camera is fixed to the %s\n"
      "created_utime_us = %jd   # since the epoch, of the last view; 0: not known\n",
      calibration.camera.c_str(),
      in_hand ? "eye-in-hand" : "eye-to-hand",
      in_hand ? "robot's hand, the target to its base" : "robot's base, the target to its hand",
      intmax_t{calibration.created_utime});
  text += Format("\n[camera_pose]   # %s\n", in_hand ? "T_hand_camera" : "T_base_camera");
  text += PoseText(calibration.T_x, calibration.covariance);
  text += Format("\n[target_pose]   # %s\n", in_hand ? "T_base_target" : "T_hand_target");
  text += PoseText(calibration.T_y, calibration.target_covariance);
  text += "# Of the camera's errors (rows) with the target's (columns).\n";
  text += MatrixText("cross_covariance", calibration.cross_covariance);
  text += "\n[fit]\n";
  text += Line("squared_radius_95",
               Number(calibration.squared_radius_95),
               "error^T covariance^-1 error of the 95 % ellipsoid");
  text += Line("noise_scale", Number(calibration.noise_scale), "residuals by what was expected");
  text += Format("num_views = %d\nnum_outliers = %d   # left out\n",
                 calibration.num_views,
                 calibration.num_outliers);
  text += Line("rotation_rms_rad",
               Number(calibration.rotation_rms),
               Format("%.4f deg", calibration.rotation_rms / kDegree));
  text += Line("translation_rms_m",
               Number(calibration.translation_rms),
               Format("%.4f mm", 1e3 * calibration.translation_rms));
  text += Line("pixel_rms_px", Number(calibration.pixel_rms), "0 without images");
  text += "\n[robot]\n";
  text += Line("scale", Number(calibration.robot_scale), "true length by length that it tells");
  text += Line("time_offset_s",
               Number(calibration.time_offset),
               "the image of time t shows the hand of t + offset");
  if (calibration.intrinsics) {
    text += IntrinsicsText(*calibration.intrinsics, calibration.distortion);
  }
  return text;
}

Result<void> WriteHandEyeFile(const HandEyeFile& calibration, const std::filesystem::path& file) {
  const std::filesystem::path part = file.string() + ".part";
  if (Result<void> written = WriteFileBytes(part, HandEyeFileText(calibration)); !written) {
    return written;
  }
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (!error) return {};
  const std::string message = error.message();
  std::filesystem::remove(part, error);
  return Error{ErrorCode::kIo, Format("%s can't be written: %s", file.c_str(), message.c_str())};
}

Result<HandEyeFile> ReadHandEyeFile(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("hand-eye calibration %s is not there, expected a file that "
                        "vantage-handeye wrote",
                        file.c_str())};
  }
  return Read(ConfigReader::Open(file));
}

Result<HandEyeFile> ParseHandEyeFile(const std::string& text, const std::string& name) {
  return Read(ConfigReader::Parse(text, name));
}

}  // namespace vantage
