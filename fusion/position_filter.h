#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Parameters of the position, "clustering and averaging" (paper section 5).
struct PositionFilterParameters {
  double gate = 0.03;          ///< m, points within it of a cluster's centre belong to the cluster
  double huber = 0.004;        ///< m, farther from the mean a point counts less (Huber 1964)
  double sigma_floor = 0.001;  ///< m, of one detection, however well few of them agree

  Result<void> Validate() const;
};

/// A position that one view measured.
struct PositionView {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< m
  double weight = 1.0;                                ///< > 0
};

/// The fused position of one object.
struct PositionEstimate {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();         ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< m^2, of p_world
  std::vector<size_t> inliers;                               ///< views of the largest cluster
};

/// Takes the heaviest cluster, the views within the gate around one of them, and its Huber mean,
/// started at the median by coordinate; ties go to the first view. A wrong minority has no effect.
/// @param views at least one.
PositionEstimate FusePositions(std::span<const PositionView> views,
                               const PositionFilterParameters& parameters);

}  // namespace vantage
