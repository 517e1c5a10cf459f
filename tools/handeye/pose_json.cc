#include "tools/handeye/pose_json.h"

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/format.h"
#include "common/time_range.h"
#include "perception/model/file_bytes.h"
#include "tools/handeye/pose_file.h"

namespace vantage {
namespace {

using nlohmann::json;

constexpr size_t kLargestFile = 64U << 20U;  // bytes
constexpr int kDeepest = 8;                  // Levels of arrays and objects.

// Thrown and caught in this file alone, as the JSON library's exceptions are.
[[noreturn]] void Refuse(const std::string& message) { throw std::runtime_error(message); }

std::vector<double> Numbers(const json& list, size_t size, const char* what) {
  const bool fits = list.is_array() && list.size() == size;
  if (!fits) Refuse(Format("%s: expected a list of %zu numbers", what, size));
  std::vector<double> numbers;
  for (const json& each : list) {
    if (!each.is_number() || !std::isfinite(each.get<double>())) {
      Refuse(Format("%s: %.40s, expected a number", what, each.dump().c_str()));
    }
    numbers.push_back(each.get<double>());
  }
  return numbers;
}

RawPose MatrixPose(const json& matrix, const char* what) {
  std::vector<double> numbers;
  if (!matrix.is_array() || matrix.size() != 4) {
    Refuse(Format("%s: expected a matrix of 4 rows", what));
  }
  for (const json& row : matrix) {
    const std::vector<double> values = Numbers(row, 4, what);
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
  const Result<RawPose> pose = RawFromMatrix(numbers);
  if (!pose) Refuse(Format("%s: %s", what, pose.error().message.c_str()));
  return *pose;
}

void Known(const json& object, const char* what, std::initializer_list<const char*> names) {
  if (!object.is_object()) Refuse(Format("%s: expected an object {...}", what));
  for (const auto& [key, value] : object.items()) {
    bool known = false;
    std::string all;
    for (const char* name : names) {
      known = known || key == name;
      all += Format("%s%s", all.empty() ? "" : ", ", name);
    }
    if (!known)
      Refuse(Format("%s: unknown field '%.40s', expected %s", what, key.c_str(), all.c_str()));
  }
}

RawPose NamedPose(const json& pose, const char* what) {
  Known(pose, what, {"position_m", "quaternion_wxyz", "rotation_vector_rad", "matrix"});
  if (pose.contains("matrix")) {
    if (pose.size() != 1) Refuse(Format("%s: expected nothing beside matrix", what));
    return MatrixPose(pose.at("matrix"), what);
  }
  if (!pose.contains("position_m") ||
      pose.contains("quaternion_wxyz") == pose.contains("rotation_vector_rad")) {
    Refuse(Format("%s: expected position_m with quaternion_wxyz or rotation_vector_rad, or matrix",
                  what));
  }
  const std::vector<double> t = Numbers(pose.at("position_m"), 3, what);
  RawPose raw{.translation = {t[0], t[1], t[2]}};
  std::vector<double> rotation;
  if (pose.contains("quaternion_wxyz")) {
    rotation = Numbers(pose.at("quaternion_wxyz"), 4, what);
  } else {
    raw.kind = RawPose::Rotation::kRotationVector;
    rotation = Numbers(pose.at("rotation_vector_rad"), 3, what);
  }
  std::copy(rotation.begin(), rotation.end(), raw.rotation.begin());
  return raw;
}

RawView NamedView(const json& view, size_t index) {
  Known(view, "view", {"name", "utime", "hand", "camera"});
  for (const char* name : {"hand", "camera"}) {
    if (!view.contains(name)) Refuse(Format("%s is missing", name));
  }
  RawView read;
  read.name = Format("view %zu", index + 1);
  if (view.contains("name")) {
    if (!view.at("name").is_string()) Refuse("name: expected a text");
    read.name = view.at("name").get<std::string>();
  }
  if (view.contains("utime")) {
    const json& utime = view.at("utime");
    if (!utime.is_number_integer() || !IsPlausibleUtime(utime.get<int64_t>())) {
      Refuse("utime: expected whole microseconds since the epoch");
    }
    read.utime = utime.get<int64_t>();
  }
  read.hand = NamedPose(view.at("hand"), "hand");
  read.camera = NamedPose(view.at("camera"), "camera");
  return read;
}

RawView MoveItView(const json& pair, size_t index) {
  if (!pair.is_array() || pair.size() != 2) {
    Refuse("expected a pair of matrices [base_T_eef, camera_T_target]");
  }
  return {Format("pair %zu", index + 1),
          0,
          MatrixPose(pair[0], "base_T_eef"),
          MatrixPose(pair[1], "camera_T_target")};
}

}  // namespace

Result<std::vector<RawView>> ReadPoseJson(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  size_t index = 0;
  std::string place;
  try {
    const json root = json::parse(*bytes, [](int depth, json::parse_event_t, json&) {
      if (depth > kDeepest) Refuse(Format("nested deeper than %d, no list of poses is", kDeepest));
      return true;
    });
    const bool ours = root.is_object();
    if (ours) Known(root, "file", {"views"});
    const json& list = ours && root.contains("views") ? root.at("views") : root;
    if (!list.is_array()) Refuse("expected {\"views\": [...]} or a list of pairs of matrices");
    std::vector<RawView> views;
    for (const json& each : list) {
      place = Format("[%zu]:", index);
      views.push_back(ours ? NamedView(each, index) : MoveItView(each, index));
      ++index;
    }
    return views;
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s%s%s %.300s",
                        file.c_str(),
                        place.c_str(),
                        place.empty() ? ":" : "",
                        exception.what())};
  }
}

}  // namespace vantage
