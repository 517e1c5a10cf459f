#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/so3.h"

namespace vantage {

/// One hypothesis of an estimator: an object of a model in a pose that explains part of one depth
/// image.
struct Detection {
  std::string model_id;
  int cluster = 0;  ///< Segment of the image; hypotheses of one exclude each other.
  bool touches_border = false;  ///< The segment reaches the image's border.
  Pose T_camera_object = Pose::Identity();
  /// Of the pose's error: rotation vector (rad) and translation of the model's center (m), both in
  /// the camera's axes.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double mse = 0.0;                 ///< m^2, explained pixels to the model's surface (eq. 4)
  double inlier_fraction = 0.0;     ///< [0, 1], of the visible model pixels confirmed
  double verification_score = 0.0;  ///< [0, 1], inliers less see-through violations
};

/// All that one estimator found in one image; empty is a normal result.
struct DetectionSet {
  int64_t utime = 0;    ///< us, of the image
  int64_t seq = 0;      ///< counts sets of this estimator
  std::string channel;  ///< LCM channel that it came on; empty inside an estimator
  std::string camera;
  int64_t image_seq = 0;
  std::string estimator;
  Pose T_world_camera = Pose::Identity();  ///< at utime
  double compute_time = 0.0;               ///< s
  int num_clusters = 0;                    ///< segments that were tried
  std::vector<Detection> detections;
};

}  // namespace vantage
