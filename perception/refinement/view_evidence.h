#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/so3.h"
#include "perception/refinement/motion_equations.h"
#include "perception/refinement/multi_view_parameters.h"
#include "perception/verification/model_view.h"

namespace vantage {

/// What one view tells about a small motion of a model from where it was drawn: a rotation vector
/// about its center (rad) and a translation (m), both in the camera's axes.
struct ViewEvidence {
  Matrix6 information = Matrix6::Zero();  ///< as if the noise were the expected one
  Vector6 right = Vector6::Zero();
  /// Variance of the noise, of what was expected, as the residuals say.
  double noise_variance = 1.0;
  int pixels = 0;                ///< measurements within the robust cut
  int compared = 0;              ///< measurements where the model was drawn
  double cost = 0.0;             ///< Tukey's biweight of all compared, 0 to 1 each
  double weight = 0.0;           ///< sum of weights of `pixels`
  double weighted_square = 0.0;  ///< m^2, of the distances to the surface
};

/// How neighboring pixels count.
enum class Weighing {
  kAlike,     ///< least squares
  kWhitened,  ///< generalized least squares; 20 times slower
};

/// Draws a model where it is thought to be and holds what is measured along the same lines of sight
/// against it, point to plane. Neighboring pixels of a structured-light sensor share a matching
/// window (Konolige, Mihelich 2010), so that their noise is smooth: a third of its variance is of a
/// pixel alone (steps of disparity), the rest has the correlation of white noise under a Gaussian
/// of `correlation_px`. Least squares takes a smooth bump of noise for a motion. Weighed by the
/// inverse of the noise's covariance (generalized least squares, Aitken 1936) creases and small
/// shapes count more than wide slopes, which the noise imitates. Allocates nothing once warm.
class ViewEvidenceGatherer {
 public:
  /// @param points about so many pixels of the model are drawn, all of them if there are fewer.
  /// @param noise_variance of the parameters' one, that the sensor has as far as is known.
  ViewEvidence Gather(const ModelShape& model,
                      const Pose& T_camera_object,
                      const CameraModel& camera,
                      const DepthImage& depth,
                      int points,
                      Weighing weighing,
                      double noise_variance,
                      const MultiViewParameters& parameters);

 private:
  static constexpr size_t kPlanes = 8;  // Weight, residual, six derivatives.

  void MarkEdges(int reach);
  void Fill(const ModelShape& model,
            const Pose& T_camera_object,
            const CameraModel& camera,
            const DepthImage& depth,
            double noise_variance,
            const MultiViewParameters& parameters,
            ViewEvidence* evidence);
  // The noise's correlation times a plane.
  void Correlate(const float* x, std::span<const float> taps, float* out);
  // Its inverse times a plane.
  void Whiten(const float* plane, double correlation, float* solution);
  void Sum(Weighing weighing, double correlation, ViewEvidence* evidence);
  // Of a drawn pixel, counted from the corner of drawn_.
  [[nodiscard]] size_t Place(int i, int j) const {
    return static_cast<size_t>(j + kMargin) * stride_ + static_cast<size_t>(i + kMargin);
  }

  static constexpr int kMargin = 8;  // Around the drawn pixels: what is read of their neighbors.

  ModelView view_;
  PixelWindow drawn_;  // Of view_, in its pixels.
  size_t stride_ = 0;  // Of the planes' rows: drawn columns and a margin.
  size_t rows_ = 0;    // Drawn rows and a margin.
  size_t plane_ = 0;   // Numbers of a plane.
  // Numbers of drawn pixels, 0 where there is no measurement; eight planes, and six.
  std::vector<float> planes_, whitened_;
  std::vector<float> white_, smooth_;  // Variance of a pixel alone; amplitude of what is smooth.
  std::vector<float> rest_, direction_, correlated_, along_rows_, scaled_;  // Reused.
  std::vector<uint8_t> near_edge_, spread_;
};

}  // namespace vantage
