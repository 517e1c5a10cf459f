#pragma once

#include <Eigen/Geometry>

#include "common/camera_model.h"
#include "common/depth_rasterizer.h"
#include "common/rng.h"
#include "common/so3.h"
#include "drivers/sim/scene.h"
#include "perception/model/object_model.h"
#include "tools/contingency/trial_simulator.h"

namespace vantage {

/// Where everything is in the trials of one model. The world's z points from the wall, the plane
/// z = 0, to the camera, which looks at it squarely.
class TrialScene {
 public:
  TrialScene(const ObjectModel& model, const TrialParameters& parameters);

  struct Placement {
    Pose T_world_camera = Pose::Identity();
    Pose T_camera_object = Pose::Identity();
    /// From the camera aimed at the object's center to the camera as it is.
    Eigen::Quaterniond q_camera_aimed = Eigen::Quaterniond::Identity();
  };
  /// The object in an orientation, seen by a camera aimed at it; its distance and its place beside
  /// the optical axis are drawn.
  [[nodiscard]] Placement Place(const Eigen::Quaterniond& q_camera_object, Rng& rng) const;

  /// The pixels that a trial needs: of the object, however it lies, and some of what is around it.
  [[nodiscard]] PixelWindow Window(const Placement& placement) const;

  /// The object before its wall, which is the scene's floor: there is none behind objects so large
  /// that the segmentation would take their front for something that hangs in the air.
  [[nodiscard]] SimScene Scene(const ObjectModel& model) const;

 private:
  CameraModel camera_;
  Eigen::Vector3d center_;     // m, object frame
  double radius_;              // m, of the ball about the center that holds the mesh
  double nearest_, farthest_;  // m
  double aim_jitter_;          // m
  double wall_distance_;       // m, behind the center; < radius_: there is no wall
};

}  // namespace vantage
