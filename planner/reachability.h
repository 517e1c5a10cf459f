#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// A box along the world's axes that the camera must not be in.
struct KeepOutBox {
  std::string name;
  Eigen::Vector3d lowest = Eigen::Vector3d::Zero();   ///< m, world; of its corners
  Eigen::Vector3d highest = Eigen::Vector3d::Zero();  ///< m
};

/// A ball that the camera must not be in.
struct KeepOutSphere {
  std::string name;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m, world
  double radius = 0.1;                               ///< m
};

/// Where the camera may be, as far as that is known without asking the robot. The way there is the
/// robot's own matter.
struct ReachabilityParameters {
  Eigen::Vector3d base = Eigen::Vector3d::Zero();             ///< m, world, of the arm
  double nearest = 0.0;                                       ///< m, camera from the base
  double farthest = std::numeric_limits<double>::infinity();  ///< m
  std::vector<KeepOutBox> boxes;
  std::vector<KeepOutSphere> spheres;

  Result<void> Validate() const;
};

/// Why the camera can't be at a place: out of reach, or in which keep-out volume. Empty: it can.
std::string ReachRefusal(const ReachabilityParameters& parameters, const Pose& T_world_camera);

}  // namespace vantage
