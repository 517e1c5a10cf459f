#include "tools/support/run_metrics.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "common/format.h"

namespace vantage {
namespace {

const object_estimate_v3_t* FindInstance(const object_estimates_v3_t& objects, int32_t instance) {
  for (const object_estimate_v3_t& object : objects.objects) {
    if (object.instance_id == instance) return &object;
  }
  return nullptr;
}

void FollowInstance(const RecordedRun& run,
                    const ObjectModel& model,
                    const std::optional<Pose>& truth,
                    ObjectHistory* history) {
  int64_t start_utime = 0;
  for (const RunView& view : run.views) {
    if (start_utime == 0) start_utime = view.utime;
    std::optional<PoseError> detected;
    std::optional<PoseError> fused;
    std::optional<PoseError> refined;
    if (const auto found = view.detections.find(*history->instance);
        truth && found != view.detections.end()) {
      detected = ErrorOf(model, found->second, *truth);
    }
    if (const object_estimate_v3_t* object = FindInstance(view.objects, *history->instance)) {
      const std::optional<Pose> pose = EstimatedPose(*object);
      if (truth && pose) fused = ErrorOf(model, *pose, *truth);
      const std::optional<Pose> refined_pose = RefinedPose(*object);
      if (truth && refined_pose) refined = ErrorOf(model, *refined_pose, *truth);
      if (!history->converged) {
        history->converged = object->converged != 0;
        if (view.utime != 0) {
          history->seconds = 1e-6 * static_cast<double>(view.utime - start_utime);
        }
      }
      history->num_views = object->num_views;
    }
    history->detected.push_back(detected);
    history->fused.push_back(fused);
    history->refined.push_back(refined);
  }
}

}  // namespace

PoseError ErrorOf(const ObjectModel& model,
                  const Pose& T_world_estimate,
                  const Pose& T_world_truth) {
  PoseError error;
  error.angle = SymmetricAngle(model.symmetry,
                               Eigen::Quaterniond(T_world_estimate.linear()),
                               Eigen::Quaterniond(T_world_truth.linear()));
  error.distance = (T_world_estimate * model.center - T_world_truth * model.center).norm();
  return error;
}

std::optional<PoseError> ObjectHistory::final_error() const {
  return fused.empty() ? std::nullopt : fused.back();
}

std::optional<PoseError> ObjectHistory::final_refined_error() const {
  return refined.empty() ? std::nullopt : refined.back();
}

std::optional<double> ObjectHistory::median_detection_angle() const {
  std::vector<double> angles;
  for (const std::optional<PoseError>& error : detected) {
    if (error) angles.push_back(error->angle);
  }
  if (angles.empty()) return std::nullopt;
  std::sort(angles.begin(), angles.end());
  const size_t middle = angles.size() / 2;
  return angles.size() % 2 == 1 ? angles[middle] : 0.5 * (angles[middle - 1] + angles[middle]);
}

bool RunMetrics::Within(double largest_angle, double largest_distance) const {
  return extra.empty() && !objects.empty() &&
         std::all_of(objects.begin(), objects.end(), [&](const ObjectHistory& object) {
           const std::optional<PoseError> error = object.final_error();
           // Written so that what is not a number fails.
           return error && error->angle <= largest_angle && error->distance <= largest_distance;
         });
}

bool RunMetrics::BetterThanMedianDetection() const {
  return std::all_of(objects.begin(), objects.end(), [](const ObjectHistory& object) {
    const std::optional<PoseError> error = object.final_error();
    const std::optional<double> median = object.median_detection_angle();
    return error && median && error->angle < *median;
  });
}

std::map<size_t, int32_t> MatchToTruth(const object_estimates_v3_t& objects,
                                       const ReportSetup& setup) {
  std::vector<std::tuple<double, size_t, int32_t>> pairs;  // Distance, truth, instance.
  for (const object_estimate_v3_t& object : objects.objects) {
    const auto model = setup.models.find(object.model_id);
    const std::optional<Pose> pose = EstimatedPose(object);
    if (model == setup.models.end() || !pose) continue;
    for (size_t i = 0; i < setup.truth.size(); ++i) {
      if (setup.truth[i].model_id != object.model_id) continue;
      const double distance = ErrorOf(model->second, *pose, setup.truth[i].T_world_object).distance;
      if (distance <= 0.5 * model->second.diameter) {
        pairs.emplace_back(distance, i, object.instance_id);
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::map<size_t, int32_t> matches;
  std::set<int32_t> taken;
  for (const auto& [distance, truth, instance] : pairs) {
    if (matches.contains(truth) || taken.contains(instance)) continue;
    matches[truth] = instance;
    taken.insert(instance);
  }
  return matches;
}

RunMetrics MeasureRun(const RecordedRun& run, const ReportSetup& setup) {
  RunMetrics metrics;
  const object_estimates_v3_t& last = run.views.back().objects;
  const std::map<size_t, int32_t> matches = MatchToTruth(last, setup);
  std::set<int32_t> explained;
  for (size_t i = 0; i < setup.truth.size(); ++i) {
    ObjectHistory history;
    history.model_id = setup.truth[i].model_id;
    if (const auto match = matches.find(i); match != matches.end()) {
      history.instance = match->second;
      explained.insert(match->second);
      FollowInstance(
          run, setup.models.at(history.model_id), setup.truth[i].T_world_object, &history);
    }
    metrics.objects.push_back(std::move(history));
  }
  for (const object_estimate_v3_t& object : last.objects) {
    if (object.state != object_estimate_v3_t::CONFIRMED || explained.contains(object.instance_id)) {
      continue;
    }
    const auto model = setup.models.find(object.model_id);
    if (setup.truth.empty() && model != setup.models.end()) {
      ObjectHistory history;
      history.model_id = object.model_id;
      history.instance = object.instance_id;
      FollowInstance(run, model->second, std::nullopt, &history);
      metrics.objects.push_back(std::move(history));
    } else {
      metrics.extra.push_back(Format("%s %d", object.model_id.c_str(), object.instance_id));
    }
  }
  return metrics;
}

}  // namespace vantage
