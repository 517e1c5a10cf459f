#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "perception/refinement/motion_equations.h"
#include "perception/refinement/multi_view_parameters.h"
#include "perception/verification/model_view.h"

namespace vantage {

/// A depth image and where the robot says that it was taken from. No segments are needed: what
/// counts is what lies near the model. A part of an image will do, as the image of a camera of
/// that size with the principal point moved.
struct RefinementView {
  CameraModel camera;
  Pose T_world_camera = Pose::Identity();
  const DepthImage* depth = nullptr;  ///< m, of the camera's size; outlives the call
};

/// An object and where it is thought to be: a settled mode of fusion.
struct RefinementStart {
  ModelShape model;  ///< of a mesh of some thousand triangles (kFineLevel); outlives the call
  SymmetryGroup symmetry;
  Pose T_world_object = Pose::Identity();
  /// Images that show it, by index, ascending: those of the detections that speak for it.
  std::vector<size_t> views;
  /// Farther from the start a pose is refused: another mode, or depth of something else.
  double max_rotation = 3.0 * kDegree;  ///< rad, modulo symmetry
  double max_translation = 0.005;       ///< m, of the model's center
};

struct MultiViewRefined {
  bool is_refined = false;
  std::string note;                        ///< why not, in a sentence
  Pose T_world_object = Pose::Identity();  ///< the start where it is refused
  /// Of its error: rotation vector (rad) and translation of the model's center (m), both in the
  /// world's axes. Large in directions that no view fixes.
  Matrix6 covariance = Matrix6::Identity();
  double rms = 0.0;    ///< m, weighted distance of depth to the model's surface
  int views = 0;       ///< images that it rests on
  int64_t pixels = 0;  ///< measurements that it rests on
};

struct MultiViewResult {
  std::vector<MultiViewRefined> objects;  ///< in the order of the starts
  std::vector<Pose> T_world_camera;       ///< of the views, as adjusted
  /// What the cameras' poses in their hand are to be multiplied by from the right, where it was
  /// sought: T_hand_camera * this.
  Pose T_camera_adjusted = Pose::Identity();
};

/// Poses of several objects from the depth of several views together: point-to-plane distances
/// (Chen, Medioni 1992) by projective association (Blais, Levine 1995), cameras free about what the
/// robot tells, solved by Ceres. What the pixels of a model in a view tell about its motion is
/// summed to one block of six residuals, so that a problem has as many blocks as objects and views,
/// whatever the images' size; drawn anew a few times, it has the minimum of all distances.
///
/// A pose is refined only where the depth of all views agrees with it at least as well as with the
/// start, and where it is no farther off than allowed; else it is refused, and the start returned.
class MultiViewRefiner {
 public:
  /// @param parameters valid.
  explicit MultiViewRefiner(const MultiViewParameters& parameters);
  ~MultiViewRefiner();

  /// Bad input (poses or intrinsics that are not finite, no views, depth of another size) is
  /// refused object by object; a damaged view is as one that shows nothing. The same for equal
  /// arguments, whatever was refined before.
  MultiViewResult Refine(std::span<const RefinementStart> starts,
                         std::span<const RefinementView> views);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage
