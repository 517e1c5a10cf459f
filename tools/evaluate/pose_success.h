#pragma once

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/so3.h"
#include "perception/depth_noise.h"
#include "perception/model/object_model.h"

namespace vantage {

/// When a single view's pose counts as right.
struct PoseSuccessParameters {
  double max_angle = 5.0 * kDegree;  ///< rad, modulo the model's symmetry
  double max_distance = 0.05;        ///< of the diameter, between the model's centers
  double noise_sigmas = 3.0;         ///< by which one pixel's depth may differ unseen
  double model_error = 0.001;        ///< m, standard deviation of a scan or a print
  double max_share = 0.02;           ///< of the visible pixels, that may differ by more
  int edge_px = 2;                   ///< px by which silhouettes may be off
  double occluder_gap = 0.015;       ///< m; what is measured nearer than that hides (BOP's delta)
  DepthNoise noise;
};

/// How an estimated pose compares with the true one.
struct PoseSuccess {
  double angle = 0.0;        ///< rad in [0, pi], modulo symmetry; NaN where the pose is not finite
  double distance = 0.0;     ///< m, between the model's centers; NaN likewise
  double discrepancy = 1.0;  ///< [0, 1], of the visible pixels those that tell the poses apart
  double deviation = 0.0;    ///< root mean square of the other pixels' differences, in sigmas
  bool is_within = false;    ///< angle and distance are
  bool is_indistinguishable = false;  ///< a measured image could not tell the two poses apart

  [[nodiscard]] bool succeeded() const { return is_within || is_indistinguishable; }
};

/// Compares angle and distance, and what a camera would see: the model is drawn in both poses, and
/// over the pixels where either is visible in `measured` (Hodan et al., "On Evaluation of 6D Object
/// Pose Estimation", ECCV workshops 2016, visible surface discrepancy; not measured counts as
/// visible) those are counted that tell the poses apart: no pixel of the other picture within
/// `edge_px` has the same depth within `noise_sigmas` of the sensor's noise along the line of
/// sight. The poses are indistinguishable when these are at most `max_share` and the others differ
/// by at most one sigma in the root mean square: one pixel's noise hides 3 sigmas, but thousands of
/// pixels that are all off by 2 show it. So a hidden handle is excused, which leaves no pixel that
/// differs, and a visible one that is elsewhere is not.
/// Poses are never indistinguishable where the true one is not in view.
/// @param measured of the camera's width and height.
PoseSuccess JudgePose(const ObjectModel& model,
                      const Pose& T_camera_true,
                      const Pose& T_camera_estimated,
                      const DepthImage& measured,
                      const CameraModel& camera,
                      const PoseSuccessParameters& parameters = {});

}  // namespace vantage
