#include "tools/evaluate/ycbv_dataset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <locale>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "tools/evaluate/dataset_scan.h"
#include "tools/support/png_image.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kMetaSuffix = "-meta.json";
constexpr size_t kLargestText = 16U << 20U;  // bytes

/// Where a scan's frame is, seen from that of YCB-Video, nearly.
struct KnownScan {
  const char* name;
  const char* mesh;
  std::array<double, 3> rotation_deg;  // Vector of the rotation from points to scan.
  std::array<double, 3> translation;   // m
};

constexpr std::array<KnownScan, 4> kScans = {
    {{"002_master_chef_can", "ycb_MasterChefCan.obj", {0.0, 0.0, 0.5}, {-0.007, 0.014, 0.0}},
     {"009_gelatin_box", "ycb_GelatinBox.obj", {80.4, 41.4, 23.0}, {0.0031, 0.0001, 0.030}},
     {"010_potted_meat_can", "ycb_PottedMeatCan.obj", {-0.5, 0.5, -37.1}, {0.003, 0.011, 0.0}},
     {"061_foam_brick", "ycb_FoamBrick.obj", {1.5, 2.3, -18.9}, {-0.010, -0.002, 0.0}}}};

Error BadJson(const fs::path& file, const std::string& what) {
  return Error{ErrorCode::kCorrupt, Format("%s: %s", file.c_str(), what.c_str())};
}

// Rows x columns finite numbers under a key.
template <int kRows, int kColumns>
Result<Eigen::Matrix<double, kRows, kColumns>> MatrixOf(const fs::path& file,
                                                        const Json& json,
                                                        const char* key) {
  const auto bad = [&] {
    return BadJson(file,
                   Format("%s is absent or not %d x %d finite numbers", key, kRows, kColumns));
  };
  if (!json.is_object() || !json.contains(key)) return bad();
  const Json& rows = json[key];
  Eigen::Matrix<double, kRows, kColumns> matrix;
  if (!rows.is_array() || rows.size() != kRows) return bad();
  for (int i = 0; i < kRows; ++i) {
    const Json& row = rows[static_cast<size_t>(i)];
    if (!row.is_array() || row.size() != kColumns) return bad();
    for (int j = 0; j < kColumns; ++j) {
      const Json& number = row[static_cast<size_t>(j)];
      if (!number.is_number() || !std::isfinite(number.get<double>())) return bad();
      matrix(i, j) = number.get<double>();
    }
  }
  return matrix;
}

/// An object as a frame's JSON has it.
struct LabeledObject {
  std::string name;
  int label = 0;  // In the label image.
  Pose T_camera_points = Pose::Identity();
};

struct Frame {
  fs::path stem;  // What its files' names begin with.
  CameraModel camera;
  double depth_unit = 0.0;  // m
  std::vector<LabeledObject> objects;
};

Result<LabeledObject> ReadObject(const fs::path& file, const Json& json) {
  if (!json.is_object() || !json.contains("name") || !json["name"].is_string() ||
      !json.contains("cls_index") || !json["cls_index"].is_number_unsigned() ||
      json["cls_index"] < 1 || json["cls_index"] > 255) {
    return BadJson(file, "an object has no name or no cls_index of 1 to 255");
  }
  LabeledObject object;
  object.name = json["name"].get<std::string>();
  object.label = json["cls_index"].get<int>();
  const auto matrix = MatrixOf<3, 4>(file, json, "camera_T_model_3x4");
  if (!matrix) return matrix.error();
  const Result<Eigen::Matrix3d> rotation = ProjectToRotation(matrix->leftCols<3>());
  if (!rotation) return BadJson(file, object.name + ": " + rotation.error().message);
  object.T_camera_points.linear() = *rotation;
  object.T_camera_points.translation() = matrix->col(3);
  return object;
}

Result<Frame> ReadFrame(const fs::path& file) {
  const Result<std::string> text = ReadFileBytes(file, kLargestText);
  if (!text) return text.error();
  const Json json = Json::parse(*text, nullptr, false);
  if (json.is_discarded()) return BadJson(file, "is no JSON");
  const auto K = MatrixOf<3, 3>(file, json, "intrinsic_matrix");
  if (!K) return K.error();
  Frame frame;
  const std::string path = file.string();
  frame.stem = path.substr(0, path.size() - std::string(kMetaSuffix).size());
  frame.camera.fx = (*K)(0, 0);
  frame.camera.fy = (*K)(1, 1);
  frame.camera.cx = (*K)(0, 2);
  frame.camera.cy = (*K)(1, 2);
  if (Result<void> valid = frame.camera.Validate(); !valid) {
    return BadJson(file, valid.error().message);
  }
  const Json factor = json.value("factor_depth", Json());
  if (!factor.is_number() || !(factor.get<double>() >= 1.0 && factor.get<double>() <= 1e6)) {
    return BadJson(file, "factor_depth is absent or not in 1 to 1e6");
  }
  frame.depth_unit = 1.0 / factor.get<double>();
  const Json objects = json.value("objects", Json());
  if (!objects.is_array() || objects.empty()) {
    return BadJson(file, "objects is absent, no list, or empty");
  }
  for (const Json& object : objects) {
    Result<LabeledObject> read = ReadObject(file, object);
    if (!read) return read.error();
    frame.objects.push_back(std::move(read).value());
  }
  return frame;
}

Result<std::vector<Eigen::Vector3d>> ReadPoints(const fs::path& file) {
  const Result<std::string> text = ReadFileBytes(file, kLargestText);
  if (!text) return text.error();
  std::istringstream stream(*text);
  stream.imbue(std::locale::classic());
  std::vector<Eigen::Vector3d> points;
  for (Eigen::Vector3d p; stream >> p.x() >> p.y() >> p.z();) points.push_back(p);
  constexpr size_t kFewest = 100;
  if (!stream.eof() || points.size() < kFewest) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s has %zu points%s, expected lines of three numbers, at least %zu",
                        file.c_str(),
                        points.size(),
                        stream.eof() ? "" : " and then something else",
                        kFewest)};
  }
  return points;
}

/// A scan and where its frame is.
struct AlignedScan {
  ObjectModel model;
  ScanAlignment alignment;
};

Result<AlignedScan> LoadAlignedScan(const fs::path& folder,
                                    const fs::path& mesh_file,
                                    const KnownScan& scan) {
  constexpr double kFarthest = 0.0015;  // m
  Result<ObjectModel> model = LoadScan(scan.name, mesh_file);
  if (!model) return model.error();
  const fs::path points_file = folder / "models" / scan.name / "points.xyz";
  const Result<std::vector<Eigen::Vector3d>> points = ReadPoints(points_file);
  if (!points) return points.error();
  Pose T_start(ExpSo3(kDegree * Eigen::Vector3d(scan.rotation_deg.data())));
  T_start.translation() = Eigen::Vector3d(scan.translation.data());
  const ScanAlignment alignment = AlignToScan(*points, model->mesh, T_start);
  if (!(alignment.median < kFarthest)) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s lies %.1f mm (median) off %s, expected at most %.1f mm",
                        points_file.c_str(),
                        1e3 * alignment.median,
                        mesh_file.c_str(),
                        1e3 * kFarthest)};
  }
  return AlignedScan{std::move(model).value(), alignment};
}

Result<DatasetView> ReadImages(const Frame& frame,
                               const std::map<std::string, size_t>& model_of,
                               const std::vector<Pose>& T_mesh_points) {
  const fs::path depth_file = frame.stem.string() + "-depth.png";
  const Result<Gray16Image> depth = ReadPng16(depth_file);
  if (!depth) return depth.error();
  const fs::path label_file = frame.stem.string() + "-label.png";
  const Result<Gray8Image> labels = ReadPng8(label_file);
  if (!labels) return labels.error();
  if (labels->width != depth->width || labels->height != depth->height) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s has %d x %d px, expected %d x %d as %s",
                        label_file.c_str(),
                        labels->width,
                        labels->height,
                        depth->width,
                        depth->height,
                        depth_file.filename().c_str())};
  }
  DatasetView view;
  view.name = frame.stem.filename().string();
  view.camera = frame.camera;
  view.camera.width = depth->width;
  view.camera.height = depth->height;
  view.depth = DepthImage(depth->width, depth->height);
  for (size_t i = 0; i < depth->gray.size(); ++i) {
    if (depth->gray[i] == 0) continue;
    view.depth.depth[i] = static_cast<float>(frame.depth_unit * depth->gray[i]);
  }
  for (const LabeledObject& labeled : frame.objects) {
    const auto known = model_of.find(labeled.name);
    if (known == model_of.end()) continue;
    DatasetObject object;
    object.model = known->second;
    object.T_camera_object = labeled.T_camera_points * T_mesh_points[object.model].inverse();
    for (size_t i = 0; i < labels->gray.size(); ++i) {
      if (labels->gray[i] == labeled.label) object.pixels.push_back(static_cast<uint32_t>(i));
    }
    view.objects.push_back(std::move(object));
  }
  return view;
}

Result<std::vector<Frame>> ReadFrames(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().ends_with(kMetaSuffix)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Frame> frames;
  for (const fs::path& file : files) {
    Result<Frame> frame = ReadFrame(file);
    if (!frame) return frame.error();
    frames.push_back(std::move(frame).value());
  }
  return frames;
}

// Why objects of the frames are not evaluated.
std::string NoteOfLeftOut(const std::vector<Frame>& frames,
                          const std::map<std::string, size_t>& model_of) {
  std::string names;
  for (const Frame& frame : frames) {
    for (const LabeledObject& object : frame.objects) {
      if (model_of.contains(object.name)) continue;
      names += (names.empty() ? "" : ", ") + object.name + " in " + frame.stem.filename().string();
    }
  }
  if (names.empty()) return names;
  return "Left out: " + names +
         ", of which there is no mesh; models/*/points.xyz has points without a surface, too few "
         "to make one.";
}

}  // namespace

bool IsYcbvDataset(const fs::path& folder) {
  std::error_code error;
  const fs::directory_iterator entries(folder, error);
  return std::any_of(begin(entries), end(entries), [](const fs::directory_entry& entry) {
    return entry.path().filename().string().ends_with(kMetaSuffix);
  });
}

Result<Dataset> LoadYcbvDataset(const fs::path& folder, const fs::path& meshes) {
  const Result<std::vector<Frame>> frames = ReadFrames(folder);
  if (!frames) return frames.error();
  Dataset dataset;
  dataset.what =
      "Cluttered frames of YCB-Video; all models are looked for at once in the whole "
      "image, and each in its own labeled pixels.";
  std::map<std::string, size_t> model_of;
  std::vector<Pose> T_mesh_points;
  for (const KnownScan& scan : kScans) {
    const bool is_shown = std::any_of(frames->begin(), frames->end(), [&](const Frame& frame) {
      return std::any_of(frame.objects.begin(), frame.objects.end(), [&](const LabeledObject& o) {
        return o.name == scan.name;
      });
    });
    const fs::path mesh_file = meshes / scan.mesh;
    std::error_code error;
    if (!is_shown || !fs::exists(mesh_file, error)) continue;
    Result<AlignedScan> aligned = LoadAlignedScan(folder, mesh_file, scan);
    if (!aligned) return aligned.error();
    model_of[scan.name] = dataset.models.size();
    dataset.models.push_back(std::move(aligned->model));
    T_mesh_points.push_back(aligned->alignment.T_mesh_points);
    dataset.notes.push_back(Format("%s: points of YCB-Video lie %.2f mm (median) off %s.",
                                   scan.name,
                                   1e3 * aligned->alignment.median,
                                   scan.mesh));
  }
  if (dataset.models.empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("%s has no mesh of any object in %s, expected one as %s",
                        meshes.c_str(),
                        folder.c_str(),
                        kScans.front().mesh)};
  }
  for (const Frame& frame : *frames) {
    Result<DatasetView> view = ReadImages(frame, model_of, T_mesh_points);
    if (!view) return view.error();
    dataset.views.push_back(std::move(view).value());
  }
  const std::string left_out = NoteOfLeftOut(*frames, model_of);
  if (!left_out.empty()) dataset.notes.push_back(left_out);
  return dataset;
}

}  // namespace vantage
