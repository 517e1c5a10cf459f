#pragma once

#include <vector>

#include "common/simd.h"
#include "perception/refinement/motion_equations.h"
#include "perception/refinement/refinement_parameters.h"
#include "perception/verification/model_view.h"
#include "perception/verification/observed_image.h"

namespace vantage {

struct Refined {
  Pose T_camera_object = Pose::Identity();
  int pairs = 0;     ///< measurements that the pose rests on; 0 where it is the start
  double rms = 0.0;  ///< m, weighted distance to the model's surface
  /// Of the pose's error: rotation vector (rad) and translation of the model's center (m), both in
  /// the camera's axes. Large in directions that the view does not fix. See PoseCovariance().
  Matrix6 covariance = Matrix6::Identity();
};

/// Point-to-plane ICP of pixels. The model is drawn where it is thought to be, and what is seen of
/// it is held against what is measured along the same lines of sight (projective association,
/// Blais, Levine 1995), weighted by the sensor's noise and Tukey's biweight. First on few pixels
/// with a wide cut, then drawn anew on more. Allocates nothing once warm.
class Refiner {
 public:
  /// Where it leaves too few pairs, or is not in front of the camera, the start is returned with 0
  /// pairs and a covariance that says nothing. Depth that is not finite or not positive, and pixels
  /// of no segment are left out.
  /// @param first_model as drawn at first; a coarser mesh of the same object, or the same.
  /// @param model as drawn at last.
  Refined Refine(const ModelShape& first_model,
                 const ModelShape& model,
                 const Pose& T_camera_object,
                 const SegmentedImage& image,
                 const RefinementParameters& parameters,
                 ModelView* view);

  /// Eight points of the model's surface about its center, in the camera's axes as they were
  /// drawn. What fills the last block up has no normal.
  struct Block {
    F8s<3> arm;     ///< m
    F8s<3> normal;  ///< unit, towards the camera
  };

 private:
  void Cut(const SegmentedImage& image, const PixelWindow& window);
  void Draw(const ModelShape& model, const CameraModel& camera, int points, ModelView* view);
  [[nodiscard]] MotionEquations Equations(const CameraModel& camera,
                                          double reach,
                                          const RefinementParameters& parameters) const;
  // False when too few pairs are left.
  bool Iterate(const ModelShape& model,
               const CameraModel& camera,
               int iterations,
               double reach,
               const RefinementParameters& parameters);

  PixelWindow window_;               // Of the image, in which the model may be.
  std::vector<float> window_depth_;  // m; 0 where nothing counts.
  std::vector<Block> blocks_;        // As drawn.
  Eigen::Matrix3d R_drawn_;          // Camera from object, as drawn.
  double pixels_per_point_ = 1.0;    // As drawn.
  Pose T_;                           // Camera from object.
  Eigen::Vector3d center_;           // m, of the model, in the camera.
};

}  // namespace vantage
