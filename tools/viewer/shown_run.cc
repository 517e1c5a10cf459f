#include "tools/viewer/shown_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bus/conversions.h"
#include "perception/model/object_model.h"
#include "tools/viewer/viewer_state.h"

namespace vantage {
namespace {

// Of numbers from outside; zero when they are no covariance.
Eigen::Matrix3d CovarianceFromWire(const double (&numbers)[9], double largest_variance) {
  const Eigen::Matrix3d matrix = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      static_cast<const double*>(numbers));
  if (!matrix.allFinite() || matrix.diagonal().minCoeff() < 0.0 ||
      matrix.trace() > largest_variance) {
    return Eigen::Matrix3d::Zero();
  }
  return 0.5 * (matrix + matrix.transpose());
}

std::optional<ShownObject> ObjectFromMessage(const object_estimate_v3_t& message) {
  constexpr double kLargestPositionVariance = 1.0;   // m^2
  constexpr double kLargestRotationVariance = 10.0;  // rad^2
  if (!CheckModelId(message.model_id).ok()) return std::nullopt;
  ShownObject object;
  object.instance = message.instance_id;
  object.model_id = message.model_id;
  object.state = message.state;
  object.position_covariance =
      CovarianceFromWire(message.trans_covariance, kLargestPositionVariance);
  for (const orientation_peak_v2_t& peak : message.peaks) {
    const Result<Pose> pose = PoseFromWire(message.trans, peak.quat);
    if (!pose || !std::isfinite(peak.weight)) continue;
    object.position = pose->translation();
    object.peaks.push_back({Eigen::Quaterniond(pose->linear()),
                            std::clamp(peak.weight, 0.0, 1.0),
                            CovarianceFromWire(peak.covariance, kLargestRotationVariance)});
    if (object.peaks.size() >= ViewerState::kMaxPeaks) break;
  }
  if (object.peaks.empty()) return std::nullopt;
  if (message.refinement == object_estimate_v3_t::REFINED) {
    const Result<Pose> refined = PoseFromWire(message.refined_trans, message.refined_quat);
    if (refined) object.refined = *refined;
  }
  object.entropy = std::isfinite(message.entropy) ? message.entropy : 0.0;
  object.num_views = message.num_views;
  object.converged = message.converged != 0;
  object.last_change = std::isfinite(message.last_change) ? message.last_change : -1.0;
  return object;
}

std::optional<ShownCandidate> CandidateFromMessage(const view_candidate_t& message) {
  const Result<Pose> pose = PoseFromWire(message.trans, message.quat);
  if (!pose || !std::isfinite(message.gain)) return std::nullopt;
  return ShownCandidate{*pose, message.gain, message.reachable != 0};
}

}  // namespace

Pose ShownObject::PoseOfPeak(size_t peak) const {
  if (peak == 0 && refined) return *refined;
  Pose pose = Pose::Identity();
  pose.linear() = peaks[peak].q_world_object.toRotationMatrix();
  pose.translation() = position;
  return pose;
}

const ShownObject* ShownObjects::Find(int32_t instance) const {
  const auto found = std::find_if(objects.begin(), objects.end(), [&](const ShownObject& object) {
    return object.instance == instance;
  });
  return found == objects.end() ? nullptr : &*found;
}

ShownObjects ObjectsFromMessage(const object_estimates_v3_t& message) {
  ShownObjects shown;
  shown.utime = message.utime;
  shown.num_viewpoints = std::max(0, message.num_viewpoints);
  shown.finished = message.finished != 0;
  for (const object_estimate_v3_t& each : message.objects) {
    if (shown.objects.size() >= ViewerState::kMaxObjects) break;
    std::optional<ShownObject> object = ObjectFromMessage(each);
    if (object && shown.Find(object->instance) == nullptr) {
      shown.objects.push_back(std::move(*object));
    }
  }
  return shown;
}

ShownPlan PlanFromMessage(const next_view_t& message) {
  ShownPlan plan;
  plan.utime = message.utime;
  plan.criterion = message.criterion;
  plan.reason = message.reason;
  plan.num_offered = message.candidates.size();
  for (const view_candidate_t& each : message.candidates) {
    if (plan.candidates.size() >= ViewerState::kMaxCandidates) break;
    if (const auto candidate = CandidateFromMessage(each)) plan.candidates.push_back(*candidate);
  }
  if (message.selected >= 0 && static_cast<size_t>(message.selected) < message.candidates.size()) {
    plan.chosen = CandidateFromMessage(message.candidates[static_cast<size_t>(message.selected)]);
  }
  return plan;
}

std::optional<ShownDetections> ShownFromMessage(const detections_v2_t& message,
                                                const std::string& channel) {
  const Result<DetectionSet> set = DetectionsFromMessage(message, channel);
  if (!set) return std::nullopt;
  ShownDetections shown;
  shown.utime = set->utime;
  shown.seq = set->seq;
  shown.channel = channel;
  shown.T_world_camera = set->T_world_camera;
  for (const Detection& detection : set->detections) {
    if (shown.detections.size() >= ViewerState::kMaxDetections) break;
    shown.detections.push_back({detection.model_id,
                                detection.cluster,
                                detection.verification_score,
                                set->T_world_camera * detection.T_camera_object});
  }
  return shown;
}

}  // namespace vantage
