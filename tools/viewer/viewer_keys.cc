#include "tools/viewer/viewer_keys.h"

#include <algorithm>
#include <array>
#include <vector>

#include "tools/viewer/viewer_scene.h"

namespace vantage {
namespace {

void TakeNextVector(ViewerOptions* options) {
  const std::array<Eigen::Vector3d, 4> vectors = {Eigen::Vector3d::Ones().normalized(),
                                                  Eigen::Vector3d::UnitX(),
                                                  Eigen::Vector3d::UnitY(),
                                                  Eigen::Vector3d::UnitZ()};
  size_t next = 0;
  for (size_t i = 0; i < vectors.size(); ++i) {
    if (options->vector.isApprox(vectors[i])) next = (i + 1) % vectors.size();
  }
  options->vector = vectors[next];
}

void TakeNextObject(const ViewerState& state, ViewerOptions* options) {
  const auto& objects = state.objects().objects;
  const ShownObject* chosen = ChosenObject(state, *options);
  if (chosen == nullptr) return;
  const auto index = static_cast<size_t>(chosen - objects.data());
  options->object = objects[(index + 1) % objects.size()].instance;
}

std::optional<int64_t> After(const std::vector<int64_t>& times, int64_t utime) {
  const auto found = std::upper_bound(times.begin(), times.end(), utime);
  if (found == times.end()) return std::nullopt;
  return *found;
}

std::optional<int64_t> Before(const std::vector<int64_t>& times, int64_t utime) {
  const auto found = std::lower_bound(times.begin(), times.end(), utime);
  if (found == times.begin()) return std::nullopt;
  return *(found - 1);
}

}  // namespace

bool ChangeOptions(const std::string& key, const ViewerState& state, ViewerOptions* options) {
  if (key == "v") {
    TakeNextVector(options);
  } else if (key == "o") {
    TakeNextObject(state, options);
  } else if (key == "c") {
    options->cloud_color = options->cloud_color == CloudColor::kImage    ? CloudColor::kHeight
                           : options->cloud_color == CloudColor::kHeight ? CloudColor::kDepth
                                                                         : CloudColor::kImage;
  } else if (key == "d") {
    options->show_cloud = !options->show_cloud;
  } else if (key == "n") {
    options->show_candidates = !options->show_candidates;
  } else if (key == "u") {
    options->show_uncertainty = !options->show_uncertainty;
  } else {
    return false;
  }
  return true;
}

std::optional<int64_t> KeyTime(const std::string& key, const LogPlayer& player, int64_t utime) {
  if (key == "Right") return After(player.marks(), utime);
  if (key == "Left") return Before(player.marks(), utime);
  if (key == "Next") return After(player.views(), utime);
  if (key == "Prior") return Before(player.views(), utime);
  if (key == "Home") return player.start_utime();
  if (key == "End") return player.end_utime();
  return std::nullopt;
}

std::string KeyHelp() {
  return "Keys: space plays and pauses, + and - change the speed, Left and Right go by event, Page "
         "Up and Down by view, Home and End; v another vector, o another object, c the cloud's "
         "color, d cloud, n candidates and u uncertainty on and off, f the usual view, s a "
         "screenshot, q quits. The mouse turns (left), moves (middle) and zooms (right, wheel).";
}

}  // namespace vantage
