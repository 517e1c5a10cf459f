#include "fusion/viewpoints.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "common/format.h"

namespace vantage {

Result<void> ViewpointParameters::Validate() const {
  if (!(rotation > 0.0 && rotation <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("viewpoint rotation = %g rad, expected above 0 and at most pi", rotation)};
  }
  if (!(translation > 0.0 && std::isfinite(translation))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("viewpoint translation = %g m, expected above 0", translation)};
  }
  return {};
}

double ViewingAngle(const Pose& a, const Pose& b) {
  const Eigen::Vector3d z_a = a.linear().col(2);
  const Eigen::Vector3d z_b = b.linear().col(2);
  return std::atan2(z_a.cross(z_b).norm(), z_a.dot(z_b));
}

int FindViewpoint(const std::vector<Viewpoint>& viewpoints,
                  const Pose& T_world_camera,
                  const ViewpointParameters& parameters) {
  int nearest = -1;
  double smallest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < viewpoints.size(); ++i) {
    const Pose& known = viewpoints[i].T_world_camera;
    const double distance = (known.translation() - T_world_camera.translation()).norm();
    if (distance > parameters.translation || distance >= smallest) continue;
    if (ViewingAngle(known, T_world_camera) > parameters.rotation) continue;
    smallest = distance;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace vantage
