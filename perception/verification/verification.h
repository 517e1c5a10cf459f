#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "perception/depth_noise.h"
#include "perception/verification/model_view.h"
#include "perception/verification/observed_image.h"

namespace vantage {

struct VerificationParameters {
  double inlier_sigmas = 3.0;   ///< tolerance in standard deviations of the sensor's noise
  double model_error = 0.0015;  ///< m, standard deviation of model and slowly varying sensor bias
  int edge_px = 2;              ///< px by which the silhouette may be off, at full resolution
  int coarse_step = 4;          ///< px; every so many are compared to rank hypotheses
  double min_score = 0.8;       ///< [0, 1]; hypotheses of less are no detection
  /// [0, 1], likewise of Verification::visible_fraction(): any flat patch is a box of which the
  /// rest is hidden.
  double min_visible = 0.5;
  double outlier_cost = 8.0;  ///< nats, of a pixel that contradicts the hypothesis
  /// nats, of a pixel of the model, seen head on, where nothing was measured: by the squared cosine
  /// of the slant. Shadows take some of every object, but a handle of which nothing is measured is
  /// rather elsewhere.
  double missing_cost = 2.0;
  /// nats, saved by a pixel of another cluster on the model's surface: a handle may be a cluster of
  /// its own.
  double foreign_gain = 1.0;
  DepthNoise noise;
  Result<void> Validate() const;
};

/// How a model in a pose agrees with an image; counts are of compared pixels.
struct Verification {
  int inliers = 0;       ///< measured on the model's surface
  int occluded = 0;      ///< measured nearer, on another cluster
  int seen_through = 0;  ///< measured clearly farther than the model's surface
  int in_front = 0;      ///< measured nearer, on this cluster or on no cluster (the support)
  int missing = 0;       ///< not measured; weak evidence, which the score leaves out
  int edge = 0;          ///< off by no more than the silhouette's uncertainty; no evidence
  int unexplained = 0;   ///< pixels of the cluster that the model does not reach
  double mse = 0.0;      ///< m^2, mean squared distance of inliers to the model's surface
  double cost = 0.0;     ///< nats, negative log-likelihood but for a constant; comparable within
                         ///< one cluster and step

  /// Of the visible model pixels those confirmed, [0, 1].
  [[nodiscard]] double inlier_fraction() const {
    return Ratio(inliers, inliers + seen_through + in_front);
  }
  /// Of the model's pixels those measured on its surface, whatever hides the others, [0, 1].
  [[nodiscard]] double visible_fraction() const {
    return Ratio(inliers, inliers + occluded + seen_through + in_front + missing + edge);
  }
  /// Inliers of all pixels that speak for or against, [0, 1].
  [[nodiscard]] double score() const {
    return Ratio(inliers, inliers + seen_through + in_front + unexplained);
  }

 private:
  static double Ratio(int part, int whole) {
    return whole > 0 ? static_cast<double>(part) / whole : 0.0;
  }
};

/// Renders the model and compares pixel by pixel (paper section 3.1).
/// @param image taken up with `parameters.edge_px`; prepares itself as far as needed.
/// @param cluster index of the segment that the hypothesis is to explain.
/// @param step every so many pixels of rows and columns.
/// @param bound nats; gives up as soon as the cost is more, and then only `cost` means something:
///   it is more than `bound`, and no more than it would have become.
Verification Verify(const ModelShape& model,
                    const Pose& T_camera_object,
                    ObservedImage* image,
                    size_t cluster,
                    int step,
                    const VerificationParameters& parameters,
                    ModelView* view,
                    double bound = std::numeric_limits<double>::infinity());

/// As above, for a single hypothesis of an image.
Verification Verify(const ModelShape& model,
                    const Pose& T_camera_object,
                    const SegmentedImage& image,
                    size_t cluster,
                    int step,
                    const VerificationParameters& parameters,
                    ModelView* view);

/// Sets `explained[pixel]` to 1 for every pixel of the image that is measured on the model.
void MarkExplained(const ModelShape& model,
                   const Pose& T_camera_object,
                   ObservedImage* image,
                   const VerificationParameters& parameters,
                   ModelView* view,
                   std::vector<uint8_t>* explained);
/// As above, for a single hypothesis of an image.
void MarkExplained(const ModelShape& model,
                   const Pose& T_camera_object,
                   const SegmentedImage& image,
                   const VerificationParameters& parameters,
                   ModelView* view,
                   std::vector<uint8_t>* explained);

}  // namespace vantage
