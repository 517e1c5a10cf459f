#include "planner/occlusion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/depth_rasterizer.h"
#include "common/format.h"

namespace vantage {
namespace {

constexpr int kTile = 32;  // px
constexpr double kMiddle = 0.5 * (kTile - 1);

// Ball about an object, seen by the camera.
struct Ball {
  Eigen::Vector3d p_camera;
  double distance;
  double angle;  // rad, half of what it subtends.
};

Ball SeeBall(const PlannedObject& object, const Pose& T_camera_world) {
  const Eigen::Vector3d p_camera = T_camera_world * object.center_world;
  const double distance = p_camera.norm();
  const double sine = object.radius / std::max(distance, 1e-9);
  return {p_camera, distance, sine < 1.0 ? std::asin(sine) : std::numbers::pi};
}

bool MayHide(const PlannedObject& other, const Ball& ball, const Ball& other_ball, double radius) {
  if (other.mesh == nullptr) return false;
  if (other_ball.distance - other.radius > ball.distance + radius) return false;
  const double apart = std::atan2(ball.p_camera.cross(other_ball.p_camera).norm(),
                                  ball.p_camera.dot(other_ball.p_camera));
  return apart < ball.angle + other_ball.angle;
}

// A camera like `camera` in its place, whose image is a tile that a ball fills, and where the
// border of `camera`'s image lies in it.
struct Tile {
  Tile(const CameraModel& camera, const Ball& ball, double radius) {
    const Eigen::Vector3d& p = ball.p_camera;
    const double f = kMiddle * (p.z() - radius) / radius;
    model = {kTile, kTile, f, f, kMiddle - f * p.x() / p.z(), kMiddle - f * p.y() / p.z()};
    const Eigen::Vector2d low = model.Project(camera.Unproject(-0.5, -0.5, 1.0));
    const Eigen::Vector2d high =
        model.Project(camera.Unproject(camera.width - 0.5, camera.height - 0.5, 1.0));
    border = Eigen::AlignedBox2d(low, high);
  }
  [[nodiscard]] bool IsInImage(size_t pixel) const {
    return border.contains(
        Eigen::Vector2d(static_cast<double>(pixel % kTile), static_cast<double>(pixel / kTile)));
  }
  [[nodiscard]] bool IsWhole() const {
    return border.contains(
        Eigen::AlignedBox2d(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(kTile - 1.0, kTile - 1.0)));
  }

  CameraModel model;
  Eigen::AlignedBox2d border;
};

// One object from one place.
Visibility Look(const Tile& tile,
                const Pose& T_camera_world,
                std::span<const PlannedObject> objects,
                size_t index,
                const std::vector<size_t>& others) {
  DepthRasterizer rasterizer(tile.model);
  const auto draw = [&](size_t i) {
    rasterizer.Draw(
        *objects[i].mesh, T_camera_world * objects[i].T_world_object, static_cast<uint32_t>(i));
  };
  draw(index);
  std::vector<size_t> alone;
  for (size_t pixel = 0; pixel < rasterizer.mesh_ids().size(); ++pixel) {
    if (rasterizer.mesh_ids()[pixel] != DepthRasterizer::kNoId) alone.push_back(pixel);
  }
  for (const size_t other : others) draw(other);
  std::vector<size_t> hidden_by(objects.size() + 1, 0);  // The last: by the image's border.
  for (const size_t pixel : alone) {
    const size_t winner = rasterizer.mesh_ids()[pixel];
    if (!tile.IsInImage(pixel)) {
      ++hidden_by.back();
    } else if (winner != index) {
      ++hidden_by[winner];
    }
  }
  size_t hidden = 0;
  for (const size_t count : hidden_by) hidden += count;
  if (hidden == 0) return {};
  const auto most = std::max_element(hidden_by.begin(), hidden_by.end()) - hidden_by.begin();
  return {1.0 - static_cast<double>(hidden) / static_cast<double>(alone.size()),
          most + 1 == std::ssize(hidden_by) ? Visibility::kImage : static_cast<int>(most)};
}

// All objects from one place.
void LookFrom(const OcclusionParameters& parameters,
              const Pose& T_world_camera,
              std::span<const PlannedObject> objects,
              std::vector<Visibility>* found) {
  const Pose T_camera_world = T_world_camera.inverse();
  std::vector<Ball> balls;
  for (const PlannedObject& object : objects) balls.push_back(SeeBall(object, T_camera_world));
  std::vector<size_t> others;
  for (size_t i = 0; i < objects.size(); ++i) {
    const PlannedObject& object = objects[i];
    const double table = parameters.table_height.value_or(-1e9);
    if (T_world_camera.translation().z() < table && object.center_world.z() > table) {
      found->push_back({0.0, Visibility::kTable});
      continue;
    }
    if (object.mesh == nullptr) {
      found->push_back({});
      continue;
    }
    if (balls[i].p_camera.z() < object.radius + static_cast<double>(DepthRasterizer::kNear)) {
      found->push_back({0.0, Visibility::kImage});
      continue;
    }
    others.clear();
    for (size_t j = 0; j < objects.size(); ++j) {
      if (j != i && MayHide(objects[j], balls[i], balls[j], object.radius)) others.push_back(j);
    }
    const Tile tile(parameters.camera, balls[i], object.radius);
    const bool is_free = others.empty() && tile.IsWhole();
    found->push_back(is_free ? Visibility{} : Look(tile, T_camera_world, objects, i, others));
  }
}

}  // namespace

Result<void> OcclusionParameters::Validate() const {
  if (table_height.has_value() && !std::isfinite(*table_height)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("table_height = %g m, expected a finite number", *table_height)};
  }
  return camera.Validate();
}

double UnhiddenFactor(const Visibility& visibility) {
  return std::clamp(2.0 * visibility.share - 0.5, 0.0, 1.0);
}

std::vector<Visibility> FindOcclusion(const OcclusionParameters& parameters,
                                      std::span<const Pose> candidates,
                                      std::span<const PlannedObject> objects) {
  std::vector<Visibility> found;
  found.reserve(candidates.size() * objects.size());
  for (const Pose& T_world_camera : candidates) {
    LookFrom(parameters, T_world_camera, objects, &found);
  }
  return found;
}

std::span<const Visibility> OcclusionCache::Find(std::span<const Pose> candidates,
                                                 std::span<const PlannedObject> objects) {
  std::vector<Placed> placed;
  for (const PlannedObject& object : objects) {
    placed.push_back(
        {object.mesh, object.T_world_object.matrix(), object.center_world, object.radius});
  }
  const auto is_same = [](const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); };
  if (placed != placed_ ||
      !std::equal(
          candidates.begin(), candidates.end(), candidates_.begin(), candidates_.end(), is_same)) {
    found_ = FindOcclusion(parameters_, candidates, objects);
    placed_ = std::move(placed);
    candidates_.assign(candidates.begin(), candidates.end());
  }
  return found_;
}

}  // namespace vantage
