#include "tools/evaluate/turntable_dataset.h"

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "tools/evaluate/dataset_scan.h"
#include "tools/support/png_image.h"
#include "tools/support/view_folder.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPoseFile = "camera_T_model.csv";
constexpr const char* kIntrinsicsFile = "Intrinsic.txt";
constexpr size_t kLargestText = 1U << 20U;  // bytes
constexpr size_t kMostViews = 1000;
constexpr size_t kColumns = 25;  // The view's number and two poses; what follows is not read.

struct PoseLine {
  int view = 0;
  Pose T_markers = Pose::Identity();
  Pose T_refined = Pose::Identity();
};

// A pose of 12 numbers, row by row.
Result<Pose> PoseOf(const double* numbers) {
  Eigen::Matrix3d R;
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    R.row(row) << numbers[4 * row], numbers[4 * row + 1], numbers[4 * row + 2];
    pose.translation()(row) = numbers[4 * row + 3];
  }
  const Result<Eigen::Matrix3d> rotation = ProjectToRotation(R);
  if (!rotation) return rotation.error();
  pose.linear() = *rotation;
  return pose;
}

Result<PoseLine> ReadLine(std::string_view line, const std::string& place) {
  std::array<double, kColumns> numbers{};
  const char* at = line.data();
  const char* end = at + line.size();
  for (size_t i = 0; i < kColumns; ++i) {
    const auto [stop, error] = std::from_chars(at, end, numbers[i]);
    const bool is_ended = stop == end || *stop == ',';
    if (error != std::errc() || !is_ended || !std::isfinite(numbers[i])) {
      return Error{
          ErrorCode::kCorrupt,
          Format("%s: column %zu of %zu is no finite number", place.c_str(), i + 1, kColumns)};
    }
    at = stop == end ? stop : stop + 1;
  }
  PoseLine read;
  if (!(numbers[0] >= 0.0 && numbers[0] < kMostViews)) {
    return Error{
        ErrorCode::kCorrupt,
        Format("%s: view %g, expected 0 to %zu", place.c_str(), numbers[0], kMostViews - 1)};
  }
  read.view = static_cast<int>(numbers[0]);
  for (const auto& [pose, first] :
       {std::pair(&read.T_markers, 1), std::pair(&read.T_refined, 13)}) {
    const Result<Pose> of_numbers = PoseOf(&numbers[static_cast<size_t>(first)]);
    if (!of_numbers) {
      return Error{of_numbers.error().code, place + ": " + of_numbers.error().message};
    }
    *pose = *of_numbers;
  }
  return read;
}

Result<std::vector<PoseLine>> ReadPoses(const fs::path& file) {
  const Result<std::string> text = ReadFileBytes(file, kLargestText);
  if (!text) return text.error();
  std::vector<PoseLine> lines;
  size_t number = 0;
  for (size_t at = 0; at < text->size();) {
    const size_t end = std::min(text->find('\n', at), text->size());
    std::string_view line = std::string_view(*text).substr(at, end - at);
    at = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (number++ == 0 || line.empty()) continue;  // The first one names the columns.
    const Result<PoseLine> read = ReadLine(line, Format("%s line %zu", file.c_str(), number));
    if (!read) return read.error();
    lines.push_back(*read);
  }
  if (lines.empty() || lines.size() > kMostViews) {
    return Error{
        ErrorCode::kCorrupt,
        Format("%s has %zu views, expected 1 to %zu", file.c_str(), lines.size(), kMostViews)};
  }
  return lines;
}

Result<DatasetView> ReadView(const fs::path& folder, CameraModel camera, const PoseLine& line) {
  const fs::path file = folder / Format("depth_%02d.png", line.view);
  const Result<Gray16Image> image = ReadPng16(file);
  if (!image) return image.error();
  camera.width = image->width;
  camera.height = image->height;
  if (Result<void> valid = camera.Validate(); !valid) {
    return Error{valid.error().code, file.string() + ": " + valid.error().message};
  }
  DatasetView view;
  view.name = Format("%02d", line.view);
  view.camera = camera;
  view.depth = DepthFromMillimetres(image->width, image->height, image->gray.data());
  view.is_segmented = true;
  view.objects.push_back({0, line.T_refined, line.T_markers, {}});
  return view;
}

}  // namespace

bool IsTurntableDataset(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / kPoseFile, error);
}

Result<Dataset> LoadTurntableDataset(const fs::path& folder, const fs::path& meshes) {
  const Result<CameraModel> camera = ReadIntrinsicsFile(folder / kIntrinsicsFile);
  if (!camera) return camera.error();
  const Result<std::vector<PoseLine>> lines = ReadPoses(folder / kPoseFile);
  if (!lines) return lines.error();
  Dataset dataset;
  dataset.what =
      "One object on a turntable, segmented depth images. The truth is the markers' pose refined "
      "on each view's own depth; the markers' own pose is the other truth.";
  for (const PoseLine& line : *lines) {
    Result<DatasetView> view = ReadView(folder, *camera, line);
    if (!view) return view.error();
    dataset.views.push_back(std::move(view).value());
  }
  Result<ObjectModel> model = LoadScan("bunny", meshes / "stanford_bunny.ply");
  if (!model) return model.error();
  dataset.models.push_back(std::move(model).value());
  const int views = static_cast<int>(dataset.views.size());
  dataset.bars = DatasetBars{views - (views + 35) / 36, 1.0 * kDegree};
  return dataset;
}

}  // namespace vantage
