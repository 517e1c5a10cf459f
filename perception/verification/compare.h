#pragma once

#include <cstddef>
#include <cstdint>

#include "perception/verification/simd_path.h"

namespace vantage {

/// A window of a drawn model and of what was measured there. Plain numbers, so that the kernels
/// need no inline function of another header. Eight values from any pixel on can be read.
struct CompareJob {
  int columns;
  int rows;
  // Drawn, see ModelView.
  const float* inverse_depth;
  const uint32_t* triangles;
  const float* plane_distance;
  size_t drawn_stride;
  // Measured, see ObservedImage::Level.
  const float* depth;
  const float* nearest;
  const float* farthest;
  const int32_t* labels;
  size_t stride;
  // The whole image, for what `nearest` and `farthest` leave open.
  const float* image;
  int image_width;
  int image_height;
  int u0, v0, step;  ///< px, of the window's first pixel, and between pixels
  int edge_px;

  float ray_x, ray_y;    ///< of the window's first pixel, at z = 1
  float ray_dx, ray_dy;  ///< between pixels
  int32_t first_label;   ///< The cluster's labels.
  int32_t last_label;

  // Noise, see DepthNoise and VerificationParameters.
  float axial_base, axial_quadratic, axial_offset;
  float lateral;         ///< m per m of depth
  float model_variance;  ///< m^2
  float squared_sigmas;  ///< square of the tolerance in standard deviations
  float missing_cost;
  double outlier_cost;
  double foreign_gain;

  double bound;        ///< gives up after the row in which the cost passes it
  uint8_t* explained;  ///< null, or of each of the image's pixels: becomes 1 where an inlier is
};

/// Counts as of Verification.
struct Compared {
  int inliers = 0;
  int occluded = 0;
  int seen_through = 0;
  int in_front = 0;
  int missing = 0;
  int edge = 0;
  double squared = 0.0;  ///< m^2, inliers' distances to the surface
  double cost = 0.0;     ///< nats
};

/// @param cost that there is already.
Compared Compare(const CompareJob& job, double cost, SimdPath path);

}  // namespace vantage
