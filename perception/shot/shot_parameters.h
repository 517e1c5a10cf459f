#pragma once

#include "common/result.h"

namespace vantage {

/// Of the proposer of paper section 3.2, which names k, t_r, t_d, t_alpha and the probability but
/// gives no values; these served on views of the bundled models under structured noise.
struct ShotParameters {
  double spacing = 0.035;          ///< of the diameter, between points that descriptors are made of
  double keypoint_spacing = 0.06;  ///< of the diameter, p_k,t and p_k,m
  double descriptor_radius = 0.2;  ///< of the diameter, of the ball that is described
  int training_views = 60;         ///< from which the model is looked at
  int descriptor_size = 64;        ///< principal components that are compared, of 352
  int k = 4;                       ///< correspondences of a target keypoint
  double t_r = 0.15;               ///< of the diameter, least distance within a triplet
  double t_d = 0.04;               ///< of the diameter, difference of corresponding distances
  double t_alpha_deg = 15.0;       ///< deg, difference of corresponding angles
  double inlier_distance = 0.05;   ///< of the diameter
  double probability = 0.99;       ///< that the largest consensus was found
  int max_iterations = 5000;       ///< triplets
  int max_hypotheses = 16;
  Result<void> Validate() const;
};

}  // namespace vantage
