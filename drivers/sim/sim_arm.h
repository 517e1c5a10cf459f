#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// Where the simulated arm can carry its camera, and how fast.
struct SimArmParameters {
  Eigen::Vector3d target{0.0, 0.0, 0.05};     ///< m, in the world; middle of the sphere of views
  double start_azimuth = -90.0 * kDegree;     ///< rad, from x towards y
  double start_elevation = 45.0 * kDegree;    ///< rad, above the horizon
  double start_radius = 0.75;                 ///< m
  double speed = 0.4;                         ///< m/s, largest
  double turn_speed = 1.0;                    ///< rad/s, largest
  double lowest_radius = 0.4;                 ///< m, from target
  double highest_radius = 1.2;                ///< m
  double lowest_elevation = 20.0 * kDegree;   ///< rad
  double highest_elevation = 85.0 * kDegree;  ///< rad, below 90 degrees
  std::optional<double> table_height;         ///< m
  double clearance = 0.1;                     ///< m, kept above the table

  /// Ranges, and the start being within reach.
  Result<void> Validate() const;
};

/// Pose at azimuth and elevation (rad) and radius (m) from the target, looking at it.
Pose ViewOnSphere(const Eigen::Vector3d& target, double azimuth, double elevation, double radius);

/// A robot that carries a camera round a target. Moves go over the sphere (azimuth, elevation and
/// radius change together), so that the camera keeps off the table and on the target; they start
/// and end at rest and keep the speed limits. Time is passed in, s, and never goes back.
class SimArm {
 public:
  /// `parameters` valid; at rest at the start pose.
  explicit SimArm(const SimArmParameters& parameters);

  /// Nothing, or why a pose is out of reach, e.g. "elevation 12.0 deg is below the lowest 20.0
  /// deg".
  [[nodiscard]] Result<void> CheckReachable(const Pose& T_world_camera) const;
  /// Sets out for a pose; in mid-move it is taken up on arrival, replacing one that waits. Errors:
  /// out of reach, and the arm goes on with what it was doing.
  Result<void> MoveTo(const Pose& T_world_camera, double now);
  /// Where the camera is.
  Pose PoseAt(double now);
  /// s until it has done all that it was asked; 0 at rest.
  double Remaining(double now);
  /// The last pose that it was sent to.
  [[nodiscard]] const Pose& destination() const { return waiting_ ? *waiting_ : path_.to; }

 private:
  struct Spherical {
    double azimuth, elevation, radius;
  };
  struct Path {
    Pose from, to;
    Spherical sphere_from, sphere_to;
    Eigen::Quaterniond aim_from, aim_to;  // From looking at the target to the true orientation.
    double start = 0.0;                   // s
    double duration = 0.0;                // s
  };

  [[nodiscard]] Spherical ToSpherical(const Pose& T_world_camera) const;
  [[nodiscard]] Path PlanPath(const Pose& from, const Pose& to, double start) const;
  [[nodiscard]] Pose PoseOnPath(const Path& path, double fraction) const;
  void Advance(double now);

  SimArmParameters parameters_;
  Path path_;
  std::optional<Pose> waiting_;
};

}  // namespace vantage
