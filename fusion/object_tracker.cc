#include "fusion/object_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "fusion/confusion/viewing_direction.h"
#include "fusion/verification_weight.h"

namespace vantage {
namespace {

constexpr size_t kNumRecentSets = 256;
// The least w_v that counts: a fit so bad (6.4 sigma_vw) tells nothing, and the ratios of weights
// much smaller than this are lost to underflow.
constexpr double kLeastWeight = 1e-9;

bool IsRigid(const Pose& pose) {
  const Eigen::Matrix3d R = pose.linear();
  return pose.matrix().allFinite() && R.determinant() > 0.0 &&
         (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3;
}

// Of each cluster the detection with the best verification score, the first of equals.
std::vector<size_t> BestOfEachCluster(const std::vector<Detection>& detections,
                                      const std::vector<bool>& valid) {
  std::map<int, size_t> best;
  for (size_t i = 0; i < detections.size(); ++i) {
    if (!valid[i]) continue;
    const auto [known, is_first] = best.try_emplace(detections[i].cluster, i);
    if (!is_first &&
        detections[i].verification_score > detections[known->second].verification_score) {
      known->second = i;
    }
  }
  std::vector<size_t> chosen;
  for (const auto& [cluster, index] : best) chosen.push_back(index);
  return chosen;
}

// Rotations of the group that stand for all of them where kernels are `spread` rad wide: neighbors
// are one to two spreads apart, or as far as the group has them.
std::vector<Eigen::Quaterniond> Spaced(const SymmetryGroup& group, double spread) {
  std::vector<Eigen::Quaterniond> spaced;
  if (group.kind == SymmetryGroup::Kind::kContinuous) {
    const auto num_turns = static_cast<int>(std::ceil(2.0 * std::numbers::pi / spread));
    const Eigen::Quaterniond flip = ExpSo3(std::numbers::pi * group.axis.unitOrthogonal());
    for (int i = 0; i < num_turns; ++i) {
      const Eigen::Quaterniond turn = ExpSo3(2.0 * std::numbers::pi * i / num_turns * group.axis);
      spaced.push_back(turn);
      if (group.flips) spaced.push_back(turn * flip);
    }
    return spaced;
  }
  for (const Eigen::Quaterniond& element : group.elements) {
    const bool apart = std::ranges::all_of(spaced, [&](const Eigen::Quaterniond& other) {
      return GeodesicAngle(element, other) >= spread;
    });
    if (apart) spaced.push_back(element);
  }
  return spaced;
}

// An object that is likely in one orientation is as likely in those that its symmetry makes equal.
std::vector<LikelyPose> WithEquivalents(const TrackedModel& model) {
  std::vector<LikelyPose> all;
  for (const LikelyPose& pose : model.likely_poses) {
    const std::vector<Eigen::Quaterniond> group = Spaced(model.symmetry, pose.spread);
    for (const Eigen::Quaterniond& element : group) {
      all.push_back({pose.q_world_object * element,
                     pose.spread,
                     pose.weight / static_cast<double>(group.size())});
    }
  }
  return all;
}

OrientationKnowledge KnowledgeOf(const TrackedModel& model,
                                 const So3Grid& grid,
                                 double uniform_share) {
  if (model.likely_poses.empty()) return {{}, model.symmetry, model.confusion.get()};
  Result<OrientationPrior> prior =
      OrientationPrior::AroundPoses(grid, WithEquivalents(model), uniform_share);
  VANTAGE_CHECK(prior.ok(), prior.error().message);
  return {std::move(prior).value(), model.symmetry, model.confusion.get()};
}

}  // namespace

Result<void> ObjectTrackerParameters::Validate() const {
  if (!(gate > 0.0 && gate_fraction >= 0.0 && overlap_fraction >= 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("gate = %g m, gate_fraction = %g, overlap_fraction = %g, expected a gate "
                        "above 0 and fractions of 0 or more",
                        gate,
                        gate_fraction,
                        overlap_fraction)};
  }
  if (!(prior_uniform_share >= 0.0 && prior_uniform_share <= 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("prior_uniform_share = %g, expected 0 to 1", prior_uniform_share)};
  }
  if (confirm_views < 1 || lost_views < 1) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("confirm_views = %d and lost_views = %d, expected 1 or more",
                        confirm_views,
                        lost_views)};
  }
  if (Result<void> valid = orientation.Validate(); !valid) return valid;
  if (Result<void> valid = position.Validate(); !valid) return valid;
  return viewpoint.Validate();
}

ObjectTracker::ObjectTracker(const So3Grid& grid,
                             const ObjectTrackerParameters& parameters,
                             std::map<std::string, TrackedModel> models)
    : grid_(&grid), parameters_(parameters), models_(std::move(models)) {
  for (const auto& [id, model] : models_) {
    knowledge_.emplace(id, KnowledgeOf(model, grid, parameters.prior_uniform_share));
  }
}

ObjectTracker::Fused ObjectTracker::NotFused(const std::string& model_id) const {
  return {{}, OrientationFilter(*grid_, parameters_.orientation, knowledge_.at(model_id)), 0.0};
}

ObjectTracker::Update ObjectTracker::Add(const DetectionSet& set) {
  Update update;
  const SetKey key{set.channel, set.seq, set.utime};
  const bool known = std::find(state_.recent_sets.begin(), state_.recent_sets.end(), key) !=
                     state_.recent_sets.end();
  if (known || !IsRigid(set.T_world_camera)) return update;
  update.viewpoint = FindViewpoint(state_.viewpoints, set.T_world_camera, parameters_.viewpoint);
  if (update.viewpoint < 0 && state_.viewpoints.size() >= kMostViewpoints) {
    update.num_beyond = 1;
    return update;
  }
  update.used = true;
  state_.recent_sets.push_back(key);
  if (state_.recent_sets.size() > kNumRecentSets) state_.recent_sets.pop_front();

  if (update.viewpoint < 0) {
    update.viewpoint = static_cast<int>(state_.viewpoints.size());
    state_.viewpoints.push_back({set.T_world_camera, 0});
    update.changed = true;
  }
  ++state_.viewpoints[static_cast<size_t>(update.viewpoint)].num_sets;

  std::vector<bool> valid;
  for (const Detection& detection : set.detections) {
    valid.push_back(IsValid(detection));
    if (!valid.back()) ++update.num_invalid;
  }
  for (const size_t index : BestOfEachCluster(set.detections, valid)) {
    const Detection& detection = set.detections[index];
    Observation observation;
    observation.viewpoint = update.viewpoint;
    observation.source = key;
    observation.index = static_cast<int>(index);
    observation.T_world_object = set.T_world_camera * detection.T_camera_object;
    observation.mse = detection.mse;
    observation.verification_score = detection.verification_score;
    const Observed observed = Observe(detection.model_id, observation);
    if (observed == Observed::kChanged) update.changed = true;
    if (observed == Observed::kBeyond) ++update.num_beyond;
  }
  return update;
}

bool ObjectTracker::IsValid(const Detection& detection) const {
  return models_.contains(detection.model_id) && IsRigid(detection.T_camera_object) &&
         std::isfinite(detection.mse) && detection.mse >= 0.0 &&
         std::isfinite(detection.verification_score) &&
         VerificationWeight(detection.mse, parameters_.orientation.sigma_vw) > kLeastWeight;
}

ObjectTracker::Observed ObjectTracker::Observe(const std::string& model_id,
                                               const Observation& observation) {
  const Eigen::Vector3d center = observation.T_world_object * ModelOf(model_id).center;
  int found = FindInstance(model_id, center);
  if (found < 0) {
    if (state_.instances.size() >= kMostInstances) return Observed::kBeyond;
    found = static_cast<int>(state_.instances.size());
    state_.instances.push_back({state_.next_id++, model_id, {}});
    fused_.push_back(NotFused(model_id));
  }
  const auto instance = static_cast<size_t>(found);
  std::vector<Observation>& observations = state_.instances[instance].observations;
  const auto place = std::lower_bound(
      observations.begin(),
      observations.end(),
      observation.viewpoint,
      [](const Observation& known, int viewpoint) { return known.viewpoint < viewpoint; });
  if (place != observations.end() && place->viewpoint == observation.viewpoint) {
    if (observation.verification_score <= place->verification_score) return Observed::kSame;
    *place = observation;
  } else {
    observations.insert(place, observation);
  }
  Fuse(instance);
  return Observed::kChanged;
}

int ObjectTracker::FindInstance(const std::string& model_id, const Eigen::Vector3d& center) const {
  const double gate = parameters_.gate + parameters_.gate_fraction * ModelOf(model_id).diameter;
  int nearest = -1;
  double smallest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < state_.instances.size(); ++i) {
    if (state_.instances[i].model_id != model_id) continue;
    const double distance = (fused_[i].position.p_world - center).norm();
    if (distance > gate || distance >= smallest) continue;
    smallest = distance;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

void ObjectTracker::Fuse(size_t instance) {
  const Instance& object = state_.instances[instance];
  const Eigen::Vector3d& center = ModelOf(object.model_id).center;
  std::vector<PositionView> positions;
  std::vector<OrientationView> orientations;
  Fused& fused = fused_[instance];
  fused.verification_weight = 0.0;
  for (const Observation& observation : object.observations) {
    const double w_v = VerificationWeight(observation.mse, parameters_.orientation.sigma_vw);
    positions.push_back({observation.T_world_object * center, w_v});
    const Pose& T_world_camera =
        state_.viewpoints[static_cast<size_t>(observation.viewpoint)].T_world_camera;
    orientations.push_back({Eigen::Quaterniond(observation.T_world_object.linear()).normalized(),
                            observation.mse,
                            AimedAt(T_world_camera, observation.T_world_object * center)});
    fused.verification_weight += w_v;
  }
  fused.position = FusePositions(positions, parameters_.position);
  fused.orientation.Fuse(std::move(orientations));
}

ObjectEstimate ObjectTracker::Estimate(size_t instance) const {
  const Instance& object = state_.instances[instance];
  const Fused& fused = fused_[instance];
  ObjectEstimate estimate;
  estimate.instance_id = object.id;
  estimate.model_id = object.model_id;
  const auto num_views = static_cast<int>(object.observations.size());
  const int num_since =
      static_cast<int>(state_.viewpoints.size()) - 1 - object.observations.back().viewpoint;
  if (num_views >= parameters_.confirm_views) {
    estimate.state = ObjectEstimate::State::kConfirmed;
  } else if (num_since >= parameters_.lost_views) {
    estimate.state = ObjectEstimate::State::kLost;
  }
  estimate.center_world = fused.position.p_world;
  estimate.center_covariance = fused.position.covariance;
  estimate.peaks = fused.orientation.peaks();
  estimate.belief = fused.orientation.belief();
  estimate.entropy = fused.orientation.histogram().Entropy();
  estimate.converged = fused.orientation.converged();
  estimate.last_change = fused.orientation.last_change();
  estimate.verification_weight = fused.verification_weight;
  estimate.observations = object.observations;
  estimate.histogram = &fused.orientation.histogram();
  const Eigen::Matrix3d R_world_object = estimate.peaks.front().q.toRotationMatrix();
  estimate.T_world_object.linear() = R_world_object;
  estimate.T_world_object.translation() =
      estimate.center_world - R_world_object * ModelOf(object.model_id).center;
  return estimate;
}

std::vector<ObjectEstimate> ObjectTracker::Estimates() const {
  std::vector<ObjectEstimate> estimates;
  for (size_t i = 0; i < state_.instances.size(); ++i) {
    if (fused_[i].orientation.peaks().empty()) continue;
    const Instance& object = state_.instances[i];
    bool is_overlapped = false;
    for (size_t j = 0; j < state_.instances.size(); ++j) {
      const Instance& other = state_.instances[j];
      if (other.model_id == object.model_id) continue;
      const double diameter =
          std::min(ModelOf(object.model_id).diameter, ModelOf(other.model_id).diameter);
      const double distance = (fused_[i].position.p_world - fused_[j].position.p_world).norm();
      if (distance >= parameters_.overlap_fraction * diameter) continue;
      const double weight = fused_[i].verification_weight;
      const double other_weight = fused_[j].verification_weight;
      is_overlapped = is_overlapped || other_weight > weight || (other_weight == weight && j < i);
    }
    if (!is_overlapped) estimates.push_back(Estimate(i));
  }
  return estimates;
}

Result<void> ObjectTracker::Restore(TrackerState state) {
  for (const Instance& instance : state.instances) {
    if (!models_.contains(instance.model_id)) {
      return Error{ErrorCode::kNotFound,
                   Format("the saved state has an object of model \"%s\", which is not in use",
                          instance.model_id.c_str())};
    }
    for (const Observation& observation : instance.observations) {
      const double sigma_vw = parameters_.orientation.sigma_vw;
      if (VerificationWeight(observation.mse, sigma_vw) > kLeastWeight) continue;
      return Error{ErrorCode::kInvalidArgument,
                   Format("the saved state has a detection of \"%s\" with a mean squared error of "
                          "%g m^2, which counts nothing with the sigma_vw of %g m^2 in use",
                          instance.model_id.c_str(),
                          observation.mse,
                          sigma_vw)};
    }
  }
  state_ = std::move(state);
  fused_.clear();
  for (size_t i = 0; i < state_.instances.size(); ++i) {
    fused_.push_back(NotFused(state_.instances[i].model_id));
    Fuse(i);
  }
  return {};
}

}  // namespace vantage
