#include "planner/reachability.h"

#include <cmath>

#include "common/format.h"

namespace vantage {
namespace {

std::string Text(const Eigen::Vector3d& p) { return Format("(%g, %g, %g)", p.x(), p.y(), p.z()); }

Result<void> CheckBox(const KeepOutBox& box) {
  const bool is_box = box.lowest.allFinite() && box.highest.allFinite() &&
                      (box.lowest.array() < box.highest.array()).all();
  if (is_box && !box.name.empty()) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      Format("keep-out box \"%s\" from %s m to %s m, expected a name and the lowest corner "
             "below the highest",
             box.name.c_str(),
             Text(box.lowest).c_str(),
             Text(box.highest).c_str())};
}

Result<void> CheckSphere(const KeepOutSphere& sphere) {
  if (sphere.center.allFinite() && sphere.radius > 0.0 && std::isfinite(sphere.radius) &&
      !sphere.name.empty()) {
    return {};
  }
  return Error{ErrorCode::kInvalidArgument,
               Format("keep-out sphere \"%s\" at %s m of %g m, expected a name, a center and a "
                      "radius above 0",
                      sphere.name.c_str(),
                      Text(sphere.center).c_str(),
                      sphere.radius)};
}

}  // namespace

Result<void> ReachabilityParameters::Validate() const {
  if (!base.allFinite() || !(nearest >= 0.0 && nearest < farthest)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("a reach from %g to %g m about the base at %s m, expected 0 <= nearest < "
                        "farthest",
                        nearest,
                        farthest,
                        Text(base).c_str())};
  }
  for (const KeepOutBox& box : boxes) {
    if (Result<void> valid = CheckBox(box); !valid) return valid;
  }
  for (const KeepOutSphere& sphere : spheres) {
    if (Result<void> valid = CheckSphere(sphere); !valid) return valid;
  }
  return {};
}

std::string ReachRefusal(const ReachabilityParameters& parameters, const Pose& T_world_camera) {
  const Eigen::Vector3d camera = T_world_camera.translation();
  const double distance = (camera - parameters.base).norm();
  if (!(distance >= parameters.nearest && distance <= parameters.farthest)) {
    return Format("out of reach: %.2f m from the base, which reaches %.2f to %.2f m",
                  distance,
                  parameters.nearest,
                  parameters.farthest);
  }
  for (const KeepOutBox& box : parameters.boxes) {
    if ((camera.array() >= box.lowest.array()).all() &&
        (camera.array() <= box.highest.array()).all()) {
      return "in the keep-out volume \"" + box.name + "\"";
    }
  }
  for (const KeepOutSphere& sphere : parameters.spheres) {
    if ((camera - sphere.center).norm() <= sphere.radius) {
      return "in the keep-out volume \"" + sphere.name + "\"";
    }
  }
  return {};
}

}  // namespace vantage
