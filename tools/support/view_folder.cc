#include "tools/support/view_folder.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLargestText = 1U << 20U;  // bytes

// How the files of one view are named: prefix + digits + suffix.
struct Naming {
  std::string_view depth_prefix;
  std::string_view depth_suffix;
  std::string_view pose_prefix;
  std::string_view pose_suffix;
};

constexpr std::array<Naming, 2> kNamings = {{{"depth_", ".png", "world_T_camera_", ".txt"},
                                             {"frame-", ".depth.png", "frame-", ".pose.txt"}}};
constexpr std::array<const char*, 2> kIntrinsics = {"Intrinsic.txt", "camera-intrinsics.txt"};

// The digits between prefix and suffix of a depth image's name.
std::optional<std::string> DigitsOf(const std::string& name, const Naming& naming) {
  const size_t around = naming.depth_prefix.size() + naming.depth_suffix.size();
  if (name.size() <= around || name.size() > around + 12) return std::nullopt;
  if (!name.starts_with(naming.depth_prefix) || !name.ends_with(naming.depth_suffix)) {
    return std::nullopt;
  }
  std::string digits = name.substr(naming.depth_prefix.size(), name.size() - around);
  if (digits.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  return digits;
}

struct DepthFile {
  int64_t number = 0;
  fs::path depth;
  fs::path pose;
};

// Depth images directly in a folder, by number; of the first naming that finds any.
std::vector<DepthFile> DepthFilesIn(const fs::path& folder) {
  for (const Naming& naming : kNamings) {
    std::vector<DepthFile> files;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      const std::optional<std::string> digits = DigitsOf(entry.path().filename().string(), naming);
      if (!digits) continue;
      DepthFile file;
      std::from_chars(digits->data(), digits->data() + digits->size(), file.number);
      file.depth = entry.path();
      file.pose =
          folder / (std::string(naming.pose_prefix) + *digits + std::string(naming.pose_suffix));
      files.push_back(std::move(file));
    }
    if (files.empty()) continue;
    std::sort(files.begin(), files.end(), [](const DepthFile& a, const DepthFile& b) {
      return a.number != b.number ? a.number < b.number : a.depth < b.depth;
    });
    return files;
  }
  return {};
}

// Those of the folder, or else of the first folder in it that has any.
std::vector<DepthFile> FindDepthFiles(const fs::path& folder) {
  std::vector<DepthFile> files = DepthFilesIn(folder);
  if (!files.empty()) return files;
  std::vector<fs::path> inside;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error)) inside.push_back(entry.path());
  }
  std::sort(inside.begin(), inside.end());
  for (const fs::path& path : inside) {
    files = DepthFilesIn(path);
    if (!files.empty()) return files;
  }
  return {};
}

// Exactly rows x columns numbers, row by row.
Result<Eigen::MatrixXd> ReadMatrix(const fs::path& file, Eigen::Index rows, Eigen::Index columns) {
  const Result<std::string> text = ReadFileBytes(file, kLargestText);
  if (!text) return text.error();
  std::istringstream stream(*text);
  stream.imbue(std::locale::classic());
  Eigen::MatrixXd matrix(rows, columns);
  Eigen::Index count = 0;
  double value = 0.0;
  while (stream >> value) {
    if (count < rows * columns) matrix(count / columns, count % columns) = value;
    ++count;
  }
  if (!stream.eof() || count != rows * columns || !matrix.allFinite()) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s has %td numbers%s, expected a matrix of %td x %td finite ones",
                        file.c_str(),
                        count,
                        stream.eof() ? "" : " and then something else",
                        rows,
                        columns)};
  }
  return matrix;
}

Result<fs::path> FindIntrinsics(const fs::path& folder, const fs::path& beside_depth) {
  std::error_code error;
  for (const fs::path& place : {folder, beside_depth}) {
    for (const char* name : kIntrinsics) {
      if (fs::exists(place / name, error)) return place / name;
    }
  }
  return Error{ErrorCode::kNotFound,
               Format("view folder %s has no intrinsics, expected %s or %s with a 3x3 matrix",
                      folder.c_str(),
                      kIntrinsics[0],
                      kIntrinsics[1])};
}

}  // namespace

Result<Pose> ReadPoseFile(const fs::path& file) {
  const Result<Eigen::MatrixXd> read = ReadMatrix(file, 4, 4);
  if (!read) return read.error();
  const Eigen::Matrix4d matrix = *read;
  if (!matrix.row(3).isApprox(Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0), 1e-6)) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s: the last row is %g %g %g %g, expected 0 0 0 1",
                        file.c_str(),
                        matrix(3, 0),
                        matrix(3, 1),
                        matrix(3, 2),
                        matrix(3, 3))};
  }
  const Result<Eigen::Matrix3d> rotation = ProjectToRotation(matrix.topLeftCorner<3, 3>());
  if (!rotation) {
    return Error{rotation.error().code, file.string() + ": " + rotation.error().message};
  }
  constexpr double kFarthest = 1e4;  // m
  if (matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff() > kFarthest) {
    return Error{
        ErrorCode::kCorrupt,
        Format("%s: the camera is more than %g m away, expected metres", file.c_str(), kFarthest)};
  }
  Pose pose = Pose::Identity();
  pose.linear() = *rotation;
  pose.translation() = matrix.topRightCorner<3, 1>();
  return pose;
}

Result<CameraModel> ReadIntrinsicsFile(const fs::path& file) {
  const Result<Eigen::MatrixXd> read = ReadMatrix(file, 3, 3);
  if (!read) return read.error();
  const Eigen::Matrix3d K = *read;
  CameraModel camera;
  camera.fx = K(0, 0);
  camera.fy = K(1, 1);
  camera.cx = K(0, 2);
  camera.cy = K(1, 2);
  const bool shape = std::abs(K(0, 1)) < 1e-6 && std::abs(K(1, 0)) < 1e-6 &&
                     K.row(2).isApprox(Eigen::RowVector3d(0.0, 0.0, 1.0), 1e-6);
  if (!shape) {
    return Error{
        ErrorCode::kCorrupt,
        Format("%s is no matrix of intrinsics, expected fx 0 cx, 0 fy cy, 0 0 1", file.c_str())};
  }
  if (Result<void> fits = camera.Validate(); !fits) {
    return Error{fits.error().code, file.string() + ": " + fits.error().message};
  }
  return camera;
}

bool IsViewFolder(const fs::path& folder) { return !FindDepthFiles(folder).empty(); }

Result<std::vector<RecordedView>> ListViewFolder(const fs::path& folder, double depth_scale) {
  const std::vector<DepthFile> files = FindDepthFiles(folder);
  if (files.empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("view folder %s has no depth images, expected depth_N.png or "
                        "frame-N.depth.png",
                        folder.c_str())};
  }
  const Result<fs::path> intrinsics = FindIntrinsics(folder, files.front().depth.parent_path());
  if (!intrinsics) return intrinsics.error();
  const Result<CameraModel> camera = ReadIntrinsicsFile(*intrinsics);
  if (!camera) return camera.error();
  std::vector<RecordedView> views;
  for (const DepthFile& file : files) {
    std::error_code error;
    if (!fs::exists(file.pose, error)) {
      return Error{ErrorCode::kNotFound,
                   Format("view %s has no pose, expected %s beside it",
                          file.depth.c_str(),
                          file.pose.filename().c_str())};
    }
    const Result<Pose> pose = ReadPoseFile(file.pose);
    if (!pose) return pose.error();
    views.push_back({file.number, file.depth, depth_scale, *camera, *pose});
  }
  return views;
}

}  // namespace vantage
