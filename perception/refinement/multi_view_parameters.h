#pragma once

#include "common/result.h"
#include "common/so3.h"
#include "perception/refinement/refinement_parameters.h"

namespace vantage {

struct MultiViewParameters {
  int rounds = 4;     ///< so often correspondences are renewed, the last time all pixels count
  int points = 8000;  ///< pixels of a model drawn in a view at last, about
  /// px beyond the outermost, of silhouettes and steps of the drawn model, left out.
  int edge_px = 0;
  double correlation_px = 1.5;  ///< px, of the smooth part of the noise, see ViewEvidenceGatherer
  /// Standard deviations of a camera's pose about what the robot tells, rad and m.
  double camera_rotation = 0.02 * kDegree;
  double camera_translation = 0.0001;
  /// Of a view's pose turned about the object: where markers beside it tell the cameras' poses.
  double view_rotation = 0.0;
  double view_translation = 0.0;
  /// True: one motion of all cameras in their hand is sought too.
  bool adjust_hand_eye = false;
  double hand_eye_rotation = 0.5 * kDegree;  ///< rad, standard deviation of that motion
  double hand_eye_translation = 0.005;       ///< m, likewise
  int min_views = 2;                         ///< fewer that show enough of an object: refused
  RefinementParameters single;  ///< sensor's noise, robust cut, bias; iterations are not used
  Result<void> Validate() const;
};

}  // namespace vantage
