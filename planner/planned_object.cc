#include "planner/planned_object.h"

namespace vantage {

std::vector<PlannedObject> PlanObjects(std::span<const ObjectEstimate> estimates) {
  std::vector<PlannedObject> objects;
  for (const ObjectEstimate& estimate : estimates) {
    PlannedObject object;
    object.instance_id = estimate.instance_id;
    object.model_id = estimate.model_id;
    object.center_world = estimate.center_world;
    object.T_world_object = estimate.T_world_object;
    object.confirmed = estimate.state == ObjectEstimate::State::kConfirmed;
    object.converged = estimate.converged;
    objects.push_back(std::move(object));
  }
  return objects;
}

std::string NameOf(const PlannedObject& object) {
  return object.model_id + " #" + std::to_string(object.instance_id);
}

}  // namespace vantage
