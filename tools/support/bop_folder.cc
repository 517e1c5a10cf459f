#include "tools/support/bop_folder.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr size_t kLargestJson = 64U << 20U;  // bytes
constexpr const char* kCameraFile = "scene_camera.json";

std::optional<int64_t> NumberOf(const std::string& text) {
  int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

// Scene folders in a folder, by number.
std::vector<fs::path> ScenesIn(const fs::path& folder) {
  std::vector<fs::path> scenes;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (NumberOf(entry.path().filename().string()) &&
        fs::exists(entry.path() / kCameraFile, error)) {
      scenes.push_back(entry.path());
    }
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

Result<fs::path> FindScene(const fs::path& folder, std::optional<int> scene) {
  std::error_code error;
  if (fs::exists(folder / kCameraFile, error)) return folder;
  const std::vector<fs::path> scenes = ScenesIn(folder);
  if (scenes.empty()) {
    return Error{
        ErrorCode::kNotFound,
        Format("%s is no BOP scene and has none in it, expected %s", folder.c_str(), kCameraFile)};
  }
  if (!scene && scenes.size() == 1) return scenes.front();
  for (const fs::path& path : scenes) {
    if (scene && NumberOf(path.filename().string()) == *scene) return path;
  }
  return Error{ErrorCode::kInvalidArgument,
               Format("%s has %zu scenes from %s to %s, expected one of them named with --scene%s",
                      folder.c_str(),
                      scenes.size(),
                      scenes.front().filename().c_str(),
                      scenes.back().filename().c_str(),
                      scene ? Format(" instead of %d", *scene).c_str() : "")};
}

// Reads the members of one image's entry; remembers the first thing that is wrong.
class EntryReader {
 public:
  EntryReader(const Json& entry, const fs::path& file, const std::string& key)
      : entry_(entry), place_(file.string() + ": image " + key) {
    if (!entry.is_object()) Fail("is no object", "an object");
  }

  template <size_t kSize>
  std::array<double, kSize> Numbers(const char* name) {
    std::array<double, kSize> values{};
    const Json* member = Find(name);
    if (member == nullptr) return values;
    if (!member->is_array() || member->size() != kSize) {
      Fail(std::string("has a bad ") + name, std::to_string(kSize) + " numbers");
      return values;
    }
    for (size_t i = 0; i < kSize; ++i) {
      if (!(*member)[i].is_number() || !std::isfinite((*member)[i].get<double>())) {
        Fail(std::string("has a bad ") + name, std::to_string(kSize) + " finite numbers");
        return values;
      }
      values[i] = (*member)[i].get<double>();
    }
    return values;
  }
  double Positive(const char* name) {
    const Json* member = Find(name);
    if (member == nullptr) return 1.0;
    const double value = member->is_number() ? member->get<double>() : 0.0;
    if (!(value > 0.0 && value < 1e6)) Fail(std::string("has a bad ") + name, "a positive number");
    return value;
  }
  void Fail(const std::string& what, const std::string& expectation) {
    if (error_) return;
    error_ = Error{ErrorCode::kCorrupt, place_ + " " + what + ", expected " + expectation};
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }
  [[nodiscard]] const std::string& place() const { return place_; }

 private:
  const Json* Find(const char* name) {
    if (error_) return nullptr;
    const auto found = entry_.find(name);
    if (found == entry_.end()) {
      Fail(std::string("has no ") + name, "it beside the other members");
      return nullptr;
    }
    return &*found;
  }

  const Json& entry_;
  std::string place_;
  std::optional<Error> error_;
};

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Result<RecordedView> ReadEntry(EntryReader& reader, std::optional<double> depth_scale) {
  RecordedView view;
  const std::array<double, 9> K = reader.Numbers<9>("cam_K");
  const std::array<double, 9> R = reader.Numbers<9>("cam_R_w2c");
  const std::array<double, 3> t = reader.Numbers<3>("cam_t_w2c");
  view.depth_scale = depth_scale ? *depth_scale : reader.Positive("depth_scale");
  view.camera.fx = K[0];
  view.camera.fy = K[4];
  view.camera.cx = K[2];
  view.camera.cy = K[5];
  if (reader.error()) return *reader.error();
  if (Result<void> fits = view.camera.Validate(); !fits) {
    return Error{fits.error().code, reader.place() + ": cam_K: " + fits.error().message};
  }
  const Result<Eigen::Matrix3d> rotation =
      ProjectToRotation(Eigen::Map<const RowMajor3d>(R.data()));
  if (!rotation) {
    return Error{rotation.error().code,
                 reader.place() + ": cam_R_w2c: " + rotation.error().message};
  }
  constexpr double kFarthest = 1e4;  // m
  const Eigen::Vector3d translation = 1e-3 * Eigen::Map<const Eigen::Vector3d>(t.data());
  if (translation.cwiseAbs().maxCoeff() > kFarthest) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s: cam_t_w2c is more than %g m, expected millimetres",
                        reader.place().c_str(),
                        kFarthest)};
  }
  Pose T_camera_world = Pose::Identity();
  T_camera_world.linear() = *rotation;
  T_camera_world.translation() = translation;
  view.T_world_camera = T_camera_world.inverse();
  return view;
}

}  // namespace

bool IsBopFolder(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / kCameraFile, error) || !ScenesIn(folder).empty();
}

Result<std::vector<RecordedView>> ListBopScene(const fs::path& folder,
                                               std::optional<int> scene,
                                               std::optional<double> depth_scale) {
  const Result<fs::path> place = FindScene(folder, scene);
  if (!place) return place.error();
  const fs::path file = *place / kCameraFile;
  const Result<std::string> text = ReadFileBytes(file, kLargestJson);
  if (!text) return text.error();
  const Json cameras = Json::parse(*text, nullptr, false);
  if (!cameras.is_object() || cameras.empty()) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s is not the cameras of a BOP scene, expected a JSON object with an "
                        "entry for each image",
                        file.c_str())};
  }
  std::vector<RecordedView> views;
  for (const auto& [key, entry] : cameras.items()) {
    const std::optional<int64_t> number = NumberOf(key);
    if (!number) {
      return Error{
          ErrorCode::kCorrupt,
          Format(
              "%s has an entry \"%.40s\", expected numbers of images", file.c_str(), key.c_str())};
    }
    EntryReader reader(entry, file, key);
    Result<RecordedView> view = ReadEntry(reader, depth_scale);
    if (!view) return view.error();
    view->number = *number;
    view->depth_file = *place / "depth" / Format("%06jd.png", intmax_t{*number});
    views.push_back(std::move(view).value());
  }
  std::sort(views.begin(), views.end(), [](const RecordedView& a, const RecordedView& b) {
    return a.number < b.number;
  });
  return views;
}

}  // namespace vantage
