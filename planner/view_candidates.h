#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// Where views are looked for: on a cap of a sphere around what they look at.
struct ViewCandidateParameters {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m, world; what the views look at
  double radius = 0.75;                              ///< m, from the target to the camera
  double lowest_elevation = 30.0 * kDegree;          ///< rad, above the horizontal plane
  double highest_elevation = 70.0 * kDegree;         ///< rad
  /// Views, spread evenly over the cap; 0: on rings, as the next two say.
  int count = 0;
  int num_elevations = 3;  ///< rings, evenly from lowest to highest
  int num_azimuths = 12;   ///< views a ring, evenly from azimuth 0 (x)

  Result<void> Validate() const;
};

/// T_world_camera of every candidate: looking at the target, the world's z up in the image. Evenly
/// spread ones lie on a spiral from the lowest, each for the same area, a golden angle apart
/// (Fibonacci lattice; Gonzalez, "Measurement of areas on a sphere using Fibonacci and
/// latitude-longitude lattices", 2010); others ring by ring from the lowest, each by azimuth, and
/// at an elevation of 90 degrees a ring is one view.
std::vector<Pose> MakeViewCandidates(const ViewCandidateParameters& parameters);

}  // namespace vantage
