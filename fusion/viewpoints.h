#pragma once

#include <vector>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// When two frames are from the same place. Errors of detections from one place repeat, so they
/// must not count as independent (paper section 5: errors "from different views").
struct ViewpointParameters {
  double rotation = 5.0 * kDegree;  ///< rad, between the optical axes; rolls are no new view
  double translation = 0.05;        ///< m

  Result<void> Validate() const;
};

/// A place that the camera looked from.
struct Viewpoint {
  Pose T_world_camera = Pose::Identity();  ///< of the first frame from there
  int num_sets = 0;                        ///< detection sets used from there
};

/// Angle between the viewing directions (optical axes) of two camera poses, rad.
double ViewingAngle(const Pose& a, const Pose& b);

/// Index of the viewpoint that a pose belongs to: of those within both limits the one nearest in
/// translation, the earlier one of equals; -1 when it is a new one.
int FindViewpoint(const std::vector<Viewpoint>& viewpoints,
                  const Pose& T_world_camera,
                  const ViewpointParameters& parameters);

}  // namespace vantage
