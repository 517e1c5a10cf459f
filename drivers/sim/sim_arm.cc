#include "drivers/sim/sim_arm.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

/// Slack for poses that went through a message or a file and back.
constexpr double kSlackDistance = 1e-6;  // m
constexpr double kSlackAngle = 1e-6;     // rad

Error OutOfReach(const char* quantity,
                 double value,
                 double lowest,
                 double highest,
                 double unit,
                 const char* unit_name) {
  const bool low = value < lowest;
  return Error{ErrorCode::kUnavailable,
               Format(unit == 1.0 ? "%s %.3f %s is %s %.3f %s" : "%s %.1f %s is %s %.1f %s",
                      quantity,
                      value / unit,
                      unit_name,
                      low ? "below the lowest" : "above the highest",
                      (low ? lowest : highest) / unit,
                      unit_name)};
}

/// Smooth from 0 to 1 with a slope of 0 at both ends and at most kSteepest between.
double Ease(double t) { return t * t * (3.0 - 2.0 * t); }
constexpr double kSteepest = 1.5;

}  // namespace

Result<void> SimArmParameters::Validate() const {
  struct Bound {
    const char* name;
    double value, lowest, highest;
  };
  const Bound bounds[] = {
      {"target x", target.x(), -100.0, 100.0},
      {"target y", target.y(), -100.0, 100.0},
      {"target z", target.z(), -100.0, 100.0},
      {"start_azimuth", start_azimuth, -2.0 * std::numbers::pi, 2.0 * std::numbers::pi},
      {"speed", speed, 1e-3, 10.0},
      {"turn_speed", turn_speed, 1e-3, 20.0},
      {"lowest_radius", lowest_radius, 0.05, 10.0},
      {"highest_radius", highest_radius, lowest_radius, 10.0},
      {"lowest_elevation", lowest_elevation, 0.0, 89.0 * kDegree},
      {"highest_elevation", highest_elevation, lowest_elevation, 89.0 * kDegree},
      {"clearance", clearance, 0.0, 10.0},
  };
  for (const Bound& bound : bounds) {
    if (!(bound.value >= bound.lowest && bound.value <= bound.highest + kSlackAngle)) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("simulated arm: %s = %g, expected %g to %g",
                          bound.name,
                          bound.value,
                          bound.lowest,
                          bound.highest)};
    }
  }
  const Pose start = ViewOnSphere(target, start_azimuth, start_elevation, start_radius);
  if (!start.matrix().allFinite()) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("simulated arm: start at elevation %g rad and radius %g m is no place",
                        start_elevation,
                        start_radius)};
  }
  if (Result<void> reach = SimArm(*this).CheckReachable(start); !reach) {
    return Error{ErrorCode::kInvalidArgument,
                 "simulated arm: its start is out of reach: " + reach.error().message};
  }
  return {};
}

Pose ViewOnSphere(const Eigen::Vector3d& target, double azimuth, double elevation, double radius) {
  const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                  std::cos(elevation) * std::sin(azimuth),
                                  std::sin(elevation));
  return LookAt(target + radius * direction, target);
}

SimArm::SimArm(const SimArmParameters& parameters) : parameters_(parameters) {
  const Pose start = ViewOnSphere(parameters.target,
                                  parameters.start_azimuth,
                                  parameters.start_elevation,
                                  parameters.start_radius);
  path_ = PlanPath(start, start, 0.0);
}

Result<void> SimArm::CheckReachable(const Pose& T_world_camera) const {
  if (!T_world_camera.matrix().allFinite()) {
    return Error{ErrorCode::kInvalidArgument, "the pose is not finite"};
  }
  const SimArmParameters& p = parameters_;
  const Spherical sphere = ToSpherical(T_world_camera);
  if (sphere.radius < p.lowest_radius - kSlackDistance ||
      sphere.radius > p.highest_radius + kSlackDistance) {
    return OutOfReach("radius", sphere.radius, p.lowest_radius, p.highest_radius, 1.0, "m");
  }
  if (sphere.elevation < p.lowest_elevation - kSlackAngle ||
      sphere.elevation > p.highest_elevation + kSlackAngle) {
    return OutOfReach(
        "elevation", sphere.elevation, p.lowest_elevation, p.highest_elevation, kDegree, "deg");
  }
  const double height = T_world_camera.translation().z();
  if (p.table_height && height < *p.table_height + p.clearance - kSlackDistance) {
    return Error{
        ErrorCode::kUnavailable,
        Format("height %.3f m is below %.3f m, the least clearance of %.3f m above the table",
               height,
               *p.table_height + p.clearance,
               p.clearance)};
  }
  return {};
}

Result<void> SimArm::MoveTo(const Pose& T_world_camera, double now) {
  if (Result<void> reach = CheckReachable(T_world_camera); !reach) return reach.error();
  Advance(now);
  if (now < path_.start + path_.duration) {
    waiting_ = T_world_camera;
  } else {
    path_ = PlanPath(path_.to, T_world_camera, now);
  }
  return {};
}

Pose SimArm::PoseAt(double now) {
  Advance(now);
  if (now >= path_.start + path_.duration) return path_.to;
  return PoseOnPath(path_, Ease(std::max(0.0, (now - path_.start) / path_.duration)));
}

double SimArm::Remaining(double now) {
  Advance(now);
  double end = path_.start + path_.duration;
  if (waiting_) end += PlanPath(path_.to, *waiting_, end).duration;
  return std::max(0.0, end - now);
}

SimArm::Spherical SimArm::ToSpherical(const Pose& T_world_camera) const {
  const Eigen::Vector3d offset = T_world_camera.translation() - parameters_.target;
  return {std::atan2(offset.y(), offset.x()),
          std::atan2(offset.z(), std::hypot(offset.x(), offset.y())),
          offset.norm()};
}

SimArm::Path SimArm::PlanPath(const Pose& from, const Pose& to, double start) const {
  Path path{.from = from,
            .to = to,
            .sphere_from = ToSpherical(from),
            .sphere_to = ToSpherical(to),
            .aim_from = Eigen::Quaterniond::Identity(),
            .aim_to = Eigen::Quaterniond::Identity(),
            .start = start};
  const double turn = path.sphere_to.azimuth - path.sphere_from.azimuth;
  path.sphere_to.azimuth = path.sphere_from.azimuth + std::remainder(turn, 2.0 * std::numbers::pi);
  const auto aim = [this](const Pose& pose, const Spherical& s) {
    const Pose look = ViewOnSphere(parameters_.target, s.azimuth, s.elevation, s.radius);
    return Eigen::Quaterniond(look.linear().transpose() * pose.linear()).normalized();
  };
  path.aim_from = aim(from, path.sphere_from);
  path.aim_to = aim(to, path.sphere_to);

  // The largest speeds along the path, per unit of its fraction, set its duration.
  constexpr int kSteps = 200;
  double metres = 0.0;
  double radians = 0.0;
  Pose last = from;
  for (int i = 1; i <= kSteps; ++i) {
    const Pose pose = PoseOnPath(path, static_cast<double>(i) / kSteps);
    metres = std::max(metres, (pose.translation() - last.translation()).norm() * kSteps);
    radians = std::max(radians,
                       kSteps * GeodesicAngle(Eigen::Quaterniond(last.linear()),
                                              Eigen::Quaterniond(pose.linear())));
    last = pose;
  }
  // What lies between the samples may be a little faster.
  constexpr double kMargin = 1.01;
  path.duration =
      kMargin * kSteepest * std::max(metres / parameters_.speed, radians / parameters_.turn_speed);
  if (metres < kSlackDistance && radians < kSlackAngle) path.duration = 0.0;
  return path;
}

Pose SimArm::PoseOnPath(const Path& path, double fraction) const {
  if (fraction >= 1.0) return path.to;
  const auto between = [fraction](double a, double b) { return a + fraction * (b - a); };
  Pose pose = ViewOnSphere(parameters_.target,
                           between(path.sphere_from.azimuth, path.sphere_to.azimuth),
                           between(path.sphere_from.elevation, path.sphere_to.elevation),
                           between(path.sphere_from.radius, path.sphere_to.radius));
  pose.linear() = pose.linear() * path.aim_from.slerp(fraction, path.aim_to).toRotationMatrix();
  return pose;
}

void SimArm::Advance(double now) {
  const double end = path_.start + path_.duration;
  if (!waiting_ || now < end) return;
  const Pose next = *waiting_;
  waiting_.reset();
  path_ = PlanPath(path_.to, next, end);
}

}  // namespace vantage
