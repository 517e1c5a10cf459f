#pragma once

#include <Eigen/Core>
#include <span>

#include "common/result.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"
#include "perception/depth_noise.h"
#include "perception/refinement/nearest_grid.h"
#include "perception/verification/verification.h"

namespace vantage {

struct RefinementParameters {
  int coarse_iterations = 8;       ///< on sampled points
  double coarse_reach = 0.10;      ///< of the diameter; pairs farther apart are cut at the start
  double coarse_reach_end = 0.04;  ///< of the diameter; at the end
  int fine_iterations = 5;         ///< on every fourth pixel, at most
  double fine_reach = 0.06;        ///< of the diameter, at the start
  int final_iterations = 5;        ///< on all pixels, at most
  double tukey_sigmas = 4.0;       ///< cut of the biweight (Tukey 1974: 4.685 for 95 % efficiency)
  double model_error = 0.0005;     ///< m, standard deviation that the sensor's noise adds to
  double converged = 1e-5;         ///< rad and m / 10; smaller steps end the iteration
  DepthNoise noise;
  Result<void> Validate() const;
};

struct Refined {
  Pose T_camera_object = Pose::Identity();
  int pairs = 0;     ///< measurements that had a part in the last step
  double rms = 0.0;  ///< m, weighted distance to the model's surface
  /// Of the pose's error: rotation vector (rad) and translation of the model's center (m), both in
  /// the camera's axes; as if pixels erred independently.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
};

/// Point-to-plane ICP (Chen, Medioni 1992) of sampled scene points to the nearest model points of
/// like normal. For poses from voting, off by some degrees and a tenth of the diameter.
Refined RefineCoarse(const NearestGrid& grid,
                     const ModelShape& model,
                     const Pose& T_camera_object,
                     std::span<const SurfacePoint> scene,
                     double focal,
                     const RefinementParameters& parameters);

/// The same of every `step`-th pixel of rows and columns to the model as it would be seen along
/// their lines of sight (projective association, Blais, Levine 1995), with the sensor's noise as
/// weight and Tukey's biweight. Pairs farther apart than `reach` m at the start, `tukey_sigmas` at
/// the end, are cut.
Refined RefineFine(const ModelShape& model,
                   const Pose& T_camera_object,
                   const SegmentedImage& image,
                   int step,
                   int iterations,
                   double reach,
                   const RefinementParameters& parameters,
                   ModelView* view);

}  // namespace vantage
