#include "tools/evaluate/simulated_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/format.h"
#include "perception/model/enclosing_ball.h"
#include "tools/support/fitting_distance.h"

namespace vantage {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// The object turned so, on the table, its center above the origin.
Pose PlaceOnTable(const ObjectModel& model, const Eigen::Quaterniond& turn) {
  Pose T_world_object = Pose::Identity();
  T_world_object.linear() = turn.toRotationMatrix();
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& vertex : model.mesh.vertices) {
    lowest = std::min(lowest, T_world_object.linear().row(2).dot(vertex.cast<double>()));
  }
  const Eigen::Vector3d center = T_world_object.linear() * model.center;
  T_world_object.translation() = Eigen::Vector3d(-center.x(), -center.y(), -lowest);
  return T_world_object;
}

Eigen::Vector3d Direction(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth),
          std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

std::vector<Pose> CircleOfViews(const Eigen::Vector3d& center,
                                double distance,
                                const SimulatedViewParameters& parameters) {
  std::vector<Pose> poses;
  for (int view = 0; view < parameters.circle_views; ++view) {
    const Eigen::Vector3d direction = Direction(kTurn * view / parameters.circle_views,
                                                parameters.circle_elevation_deg * kDegree);
    poses.push_back(LookAt(center + distance * direction, center));
  }
  return poses;
}

Pose RandomView(const Eigen::Vector3d& center,
                double scale,
                const SimulatedViewParameters& parameters,
                Rng& rng) {
  // One at a time: the order in which arguments of a call are made is not fixed.
  const double azimuth = rng.Uniform(0.0, kTurn);
  const double elevation =
      rng.Uniform(parameters.lowest_elevation_deg, parameters.highest_elevation_deg) * kDegree;
  const double distance =
      scale * rng.Uniform(parameters.nearest_distance, parameters.farthest_distance);
  Eigen::Vector3d aim = center;
  for (double& value : aim) value += rng.Uniform(-parameters.aim_jitter, parameters.aim_jitter);
  const double roll = rng.Uniform(0.0, kTurn);
  return LookAt(center + distance * Direction(azimuth, elevation), aim) *
         Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
}

}  // namespace

std::string Name(SequenceKind kind) { return kind == SequenceKind::kCircle ? "circle" : "random"; }

int SimulatedViewParameters::NumViews(SequenceKind kind) const {
  return kind == SequenceKind::kCircle ? circle_views : random_views;
}

Result<void> SimulatedViewParameters::Validate() const {
  struct Bound {
    const char* name;
    double value, lowest, highest;
  };
  const Bound bounds[] = {
      {"circle_views", static_cast<double>(circle_views), 1.0, 1000.0},
      {"circle_elevation_deg", circle_elevation_deg, 5.0, 90.0},
      {"circle_distance", circle_distance, 0.1, 10.0},
      {"random_views", static_cast<double>(random_views), 1.0, 1000.0},
      {"lowest_elevation_deg", lowest_elevation_deg, 5.0, 90.0},
      {"highest_elevation_deg", highest_elevation_deg, lowest_elevation_deg, 90.0},
      {"nearest_distance", nearest_distance, 0.1, 10.0},
      {"farthest_distance", farthest_distance, nearest_distance, 10.0},
      {"aim_jitter", aim_jitter, 0.0, 0.05},
  };
  for (const Bound& bound : bounds) {
    if (!(bound.value >= bound.lowest && bound.value <= bound.highest)) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("simulated views: %s = %g, expected %g to %g",
                          bound.name,
                          bound.value,
                          bound.lowest,
                          bound.highest)};
    }
  }
  return {};
}

SimulatedViews MakeSimulatedViews(const ObjectModel& model,
                                  SequenceKind kind,
                                  int index,
                                  const SimulatedViewParameters& parameters,
                                  const CameraModel& camera,
                                  double nearest,
                                  Rng& rng) {
  const bool is_circle = kind == SequenceKind::kCircle;
  const bool is_upright = is_circle || index % 2 == 0;
  const Eigen::Quaterniond turn =
      is_upright
          ? Eigen::Quaterniond(Eigen::AngleAxisd(rng.Uniform(0.0, kTurn), Eigen::Vector3d::UnitZ()))
          : rng.Rotation();
  SimulatedViews views;
  views.T_world_object = PlaceOnTable(model, turn);
  const Eigen::Vector3d center = views.T_world_object * model.center;
  // The aim is off by up to the diagonal of its cube.
  const double radius =
      RadiusAboutCenter(model) + (is_circle ? 0.0 : std::sqrt(3.0) * parameters.aim_jitter);
  const double closest = is_circle ? parameters.circle_distance : parameters.nearest_distance;
  views.scale = std::max(1.0, FittingDistance(radius, camera, nearest) / closest);
  if (is_circle) {
    views.T_world_camera =
        CircleOfViews(center, views.scale * parameters.circle_distance, parameters);
    return views;
  }
  for (int view = 0; view < parameters.random_views; ++view) {
    views.T_world_camera.push_back(RandomView(center, views.scale, parameters, rng));
  }
  return views;
}

}  // namespace vantage
