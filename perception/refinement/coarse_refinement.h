#pragma once

#include "common/so3.h"
#include "perception/refinement/nearest_grid.h"
#include "perception/refinement/refinement_parameters.h"
#include "perception/refinement/scene_points.h"
#include "perception/verification/model_view.h"

namespace vantage {

struct CoarselyRefined {
  Pose T_camera_object = Pose::Identity();
  int pairs = 0;     ///< measurements that had a part in the last step
  double rms = 0.0;  ///< m, weighted distance to the model's surface
};

/// Point-to-plane ICP of sampled scene points to the nearest model points of like normal. For poses
/// from voting, off by some degrees and a tenth of the diameter. A start of which too few points
/// lie near the model is returned as it is.
CoarselyRefined RefineCoarse(const NearestGrid& grid,
                             const ModelShape& model,
                             const Pose& T_camera_object,
                             const ScenePoints& points,
                             const RefinementParameters& parameters);

}  // namespace vantage
