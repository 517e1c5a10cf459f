#include "tools/contingency/trial_scene.h"

#include <algorithm>
#include <cmath>

#include "drivers/sim/sensor_model.h"
#include "perception/model/enclosing_ball.h"
#include "tools/support/fitting_distance.h"

namespace vantage {
namespace {

constexpr double kLargestGap = 0.15;    // m, between the object's ball and the wall.
constexpr double kSmallestGap = 0.05;   // m
constexpr double kHeightMargin = 0.02;  // m, below what the segmentation takes for an object.
constexpr double kWallSize = 8.0;       // m
constexpr double kWindowMargin = 20.0;  // px, around the object's ball

const SegmentationParameters& SegmentationOf(const TrialParameters& parameters) {
  return parameters.estimator == "ppf" ? parameters.ppf.estimation.segmentation
                                       : parameters.shot.estimation.segmentation;
}

}  // namespace

TrialScene::TrialScene(const ObjectModel& model, const TrialParameters& parameters)
    : camera_(parameters.camera),
      center_(model.center),
      radius_(RadiusAboutCenter(model)),
      aim_jitter_(parameters.aim_jitter) {
  const double fitting = FittingDistance(
      radius_ + std::sqrt(2.0) * aim_jitter_, parameters.camera, parameters.sensor.nearest);
  const double scale = std::max(1.0, fitting / parameters.nearest_distance);
  nearest_ = scale * parameters.nearest_distance;
  farthest_ = scale * parameters.farthest_distance;
  const SegmentationParameters& segmentation = SegmentationOf(parameters);
  const double gap = std::min(kLargestGap, segmentation.max_height - kHeightMargin - 2.0 * radius_);
  const bool has_wall =
      gap >= kSmallestGap && segmentation.support == SegmentationParameters::Support::kAuto;
  wall_distance_ = has_wall ? radius_ + gap : 0.0;
}

TrialScene::Placement TrialScene::Place(const Eigen::Quaterniond& q_camera_object, Rng& rng) const {
  const double distance = rng.Uniform(nearest_, farthest_);
  const double right = rng.Uniform(-aim_jitter_, aim_jitter_);
  const double down = rng.Uniform(-aim_jitter_, aim_jitter_);
  const Eigen::Vector3d center(right, down, distance);
  Placement placement;
  placement.q_camera_aimed = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), center);
  placement.T_camera_object.linear() =
      (placement.q_camera_aimed * q_camera_object).toRotationMatrix();
  placement.T_camera_object.translation() = center - placement.T_camera_object.linear() * center_;
  placement.T_world_camera.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  placement.T_world_camera.translation().z() = distance + wall_distance_;
  return placement;
}

PixelWindow TrialScene::Window(const Placement& placement) const {
  const Eigen::Vector3d center = placement.T_camera_object * center_;
  const Eigen::Vector2d pixel = camera_.Project(center);
  // Of a ball on the optical axis; a little off it that is right to a pixel.
  const double over_depth = radius_ / std::sqrt(center.z() * center.z() - radius_ * radius_);
  const double half_width = camera_.fx * over_depth + kWindowMargin;
  const double half_height = camera_.fy * over_depth + kWindowMargin;
  const auto begin = [](double first) {
    constexpr int kStep = SensorModel::kAlignment;
    return std::max(0, static_cast<int>(first) / kStep * kStep);
  };
  return {begin(pixel.x() - half_width),
          begin(pixel.y() - half_height),
          std::min(camera_.width - 1, static_cast<int>(pixel.x() + half_width)),
          std::min(camera_.height - 1, static_cast<int>(pixel.y() + half_height))};
}

SimScene TrialScene::Scene(const ObjectModel& model) const {
  SimScene scene;
  if (wall_distance_ > radius_) scene.floor = SimPlane{0.0, {kWallSize, kWallSize}, {0.0, 0.0}};
  scene.objects.push_back({model.id, model.mesh, Pose::Identity()});
  return scene;
}

}  // namespace vantage
