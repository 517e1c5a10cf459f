#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "common/so3.h"
#include "common/triangle_mesh.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/mode_belief.h"
#include "fusion/object_tracker.h"

namespace vantage {

/// What a criterion may know of one object in the scene.
struct PlannedObject {
  int instance_id = 0;
  std::string model_id;
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();  ///< m, of the model's center
  double radius = 0.1;                                     ///< m, of a ball about it that holds it
  Pose T_world_object = Pose::Identity();                  ///< the best estimate
  bool confirmed = false;                                  ///< seen often enough to be believed
  bool converged = false;                                  ///< by the fusion's own rule
  const ConfusionModel* confusion = nullptr;               ///< null: none was measured
  std::span<const OrientationHypothesis> belief;           ///< best first; empty: unknown
  const TriangleMesh* mesh = nullptr;  ///< m, object frame, coarse; null: not known
};

/// What the tracker knows of its objects. Who has them adds radius, confusion model, belief and
/// mesh.
std::vector<PlannedObject> PlanObjects(std::span<const ObjectEstimate> estimates);

/// "mug #2".
std::string NameOf(const PlannedObject& object);

}  // namespace vantage
