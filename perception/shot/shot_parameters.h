#pragma once

#include "common/result.h"

namespace vantage {

/// Of the proposer of paper section 3.2, which gives no values: those without a source are the best
/// of a search over the bundled models.
struct ShotParameters {
  double spacing = 0.025;          ///< of the diameter, between points that descriptors are made of
  double keypoint_spacing = 0.06;  ///< of the diameter, p_k,t and p_k,m
  double descriptor_radius = 0.2;  ///< of the diameter (Tombari et al. 2010: 15 mesh resolutions)
  int training_views = 60;         ///< from which the model is looked at
  int descriptor_size = 64;        ///< principal components that are compared, of 352
  int k = 5;                       ///< correspondences of a target keypoint
  double t_r = 0.15;               ///< of the diameter, least distance within a triplet
  double t_d = 0.04;               ///< of the diameter, difference of corresponding distances
  double t_alpha_deg = 15.0;       ///< deg, difference of corresponding angles
  double inlier_distance = 0.05;   ///< of the diameter
  double probability = 0.99;       ///< that the largest consensus was found
  int max_iterations = 10000;      ///< triplets
  int max_hypotheses = 16;
  Result<void> Validate() const;
};

}  // namespace vantage
