#include "nodes/object_refinement.h"

#include <set>
#include <utility>
#include <vector>

#include "perception/model/enclosing_ball.h"
#include "perception/verification/mesh_decimation.h"

namespace vantage {

RefinedModel::RefinedModel(const ObjectModel& model)
    : mesh(DecimateMesh(model.mesh, kFineLevel)),
      center(model.center),
      diameter(model.diameter),
      radius(RadiusAboutCenter(model)),
      symmetry(model.symmetry) {}

ObjectRefinement::ObjectRefinement(const ObjectRefinementConfig& config, Models models)
    : config_(config),
      models_(std::move(models)),
      memory_(static_cast<size_t>(config.most_views)),
      refiner_(config.parameters) {}

void ObjectRefinement::OnCamera(const CameraModel& camera) {
  if (camera_ && *camera_ == camera) return;
  camera_ = camera;
  memory_.KeepOnly({});  // Of another calibration.
}

Result<void> ObjectRefinement::OnSet(const DetectionSet& set,
                                     std::span<const ObjectEstimate> objects) {
  std::set<int64_t> used;
  for (const ObjectEstimate& object : objects) {
    for (const Observation& observation : object.observations) {
      used.insert(observation.source.utime);
    }
  }
  memory_.KeepOnly(used);
  Result<void> kept;
  if (camera_ && set.camera == config_.camera && used.contains(set.utime)) {
    kept = memory_.Keep(set.utime, set.T_world_camera, *camera_);
  }
  RefineSettled(objects);
  return kept;
}

bool ObjectRefinement::IsSettled(const ObjectEstimate& object) const {
  double weight = 0.0;
  for (const OrientationPeak& peak : object.peaks) weight += peak.weight;
  return object.state == ObjectEstimate::State::kConfirmed &&
         object.peaks.front().weight >= config_.settled_share * weight;
}

void ObjectRefinement::RefineSettled(std::span<const ObjectEstimate> objects) {
  refined_.clear();
  std::vector<RefinementView> views;
  std::map<int64_t, size_t> view_of;  // By utime.
  for (const auto& [utime, view] : memory_.views()) {
    view_of[utime] = views.size();
    views.push_back({*camera_, view.T_world_camera, &view.depth});
  }
  std::vector<RefinementStart> starts;
  std::vector<int> instances;
  for (const ObjectEstimate& object : objects) {
    if (!IsSettled(object)) continue;
    std::set<size_t> shown;
    for (const Observation& observation : object.observations) {
      const auto found = view_of.find(observation.source.utime);
      if (found != view_of.end()) shown.insert(found->second);
    }
    if (shown.size() < static_cast<size_t>(config_.parameters.min_views)) continue;
    const RefinedModel& model = *models_.at(object.model_id);
    starts.push_back({{model.mesh, model.center, model.diameter, model.radius},
                      model.symmetry,
                      object.T_world_object,
                      {shown.begin(), shown.end()},
                      config_.max_rotation,
                      config_.max_translation});
    instances.push_back(object.instance_id);
  }
  if (starts.empty()) return;
  MultiViewResult result = refiner_.Refine(starts, views);
  for (size_t i = 0; i < starts.size(); ++i) {
    refined_[instances[i]] = std::move(result.objects[i]);
  }
}

}  // namespace vantage
