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
  int num_elevations = 3;                            ///< rings, evenly from lowest to highest
  int num_azimuths = 12;                             ///< views a ring, evenly from azimuth 0 (x)

  Result<void> Validate() const;
};

/// T_world_camera of every candidate: looking at the target, the world's z up in the image; ring by
/// ring from the lowest, each by azimuth. At an elevation of 90 degrees a ring is one view.
std::vector<Pose> MakeViewCandidates(const ViewCandidateParameters& parameters);

}  // namespace vantage
