#include "planner/confusion_heuristic.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/check.h"

namespace vantage {
namespace {

// How often the detection that is seen from a direction was reported incorrectly.
double Ambiguity(const ConfusionModel& model, int direction) {
  const Eigen::Vector3d v = model.directions().Center(direction);
  double sum = 0.0;
  for (int mode = 1; mode < model.num_modes(); ++mode) {
    // The truth q_D q'* is seen from q' v.
    sum += model.ShareFrom(model.directions().CellOf(model.Difference(mode) * v), mode);
  }
  return sum;
}

// What a criterion knows of a model.
struct Judged {
  const ConfusionModel* model;
  ConfusionHeuristic heuristic;
};

// Fewer false reports from each candidate than from the worst one, of one object.
std::vector<double> FewerFalseReports(const PlanningState& state,
                                      const PlannedObject& object,
                                      const Judged& judged) {
  const Eigen::Quaterniond q_world_object = object.belief.empty()
                                                ? Eigen::Quaterniond(object.T_world_object.linear())
                                                : object.belief.front().q_world_object;
  const auto direction_from = [&](const Pose& T_world_camera) {
    return judged.model->directions().CellOf(q_world_object.conjugate() *
                                             (T_world_camera.translation() - object.center_world));
  };
  std::vector<bool> visited(static_cast<size_t>(judged.model->num_directions()), false);
  for (const Pose& view : state.visited) visited[static_cast<size_t>(direction_from(view))] = true;
  std::vector<double> gains;
  for (const Pose& candidate : state.candidates) {
    const int direction = direction_from(candidate);
    gains.push_back(visited[static_cast<size_t>(direction)]
                        ? 0.0
                        : judged.heuristic.MostFalseReports() -
                              judged.heuristic.FalseReports(direction));
  }
  return gains;
}

ViewGains Gains(const PlanningState& state, const std::map<std::string, Judged>& models) {
  const size_t num_objects = state.objects.size();
  const std::vector<double> angles = AnglesToNearestVisited(state);
  ViewGains gains{std::vector<double>(state.candidates.size(), 0.0),
                  std::vector<double>(state.candidates.size() * num_objects, 0.0)};
  for (size_t object = 0; object < num_objects; ++object) {
    const auto found = models.find(state.objects[object].model_id);
    std::vector<double> unhidden;
    if (found != models.end()) {
      unhidden = FewerFalseReports(state, state.objects[object], found->second);
    } else {
      for (const double angle : angles) {
        unhidden.push_back(AccuracyGain(state.visited.size(), angle));
      }
    }
    for (size_t i = 0; i < state.candidates.size(); ++i) {
      const double gain = unhidden[i] * state.Unhidden(i, object);
      gains.by_object[i * num_objects + object] = gain;
      gains.total[i] += gain;
    }
  }
  return num_objects > 0 ? gains : ViewGains{angles, {}};
}

}  // namespace

ConfusionHeuristic::ConfusionHeuristic(const ConfusionModel& model)
    : order_(static_cast<size_t>(model.num_directions())) {
  std::vector<double> ambiguity;
  for (int direction = 0; direction < model.num_directions(); ++direction) {
    ambiguity.push_back(Ambiguity(model, direction));
  }
  for (int direction = 0; direction < model.num_directions(); ++direction) {
    const Eigen::Vector3d v = model.directions().Center(direction);
    double sum = model.Missed(direction);
    for (const ConfusionModel::Share& share : model.SharesFrom(direction)) {
      // The detection q_GT q' is seen from q'* v.
      const Eigen::Vector3d detected = model.Difference(share.mode).conjugate() * v;
      sum += share.share * ambiguity[static_cast<size_t>(model.directions().CellOf(detected))];
    }
    false_reports_.push_back(sum);
  }
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(), [this](int a, int b) {
    return false_reports_[static_cast<size_t>(a)] < false_reports_[static_cast<size_t>(b)];
  });
}

double ConfusionHeuristic::FalseReports(int direction) const {
  VANTAGE_CHECK(direction >= 0 && static_cast<size_t>(direction) < false_reports_.size(),
                "a direction of another grid");
  return false_reports_[static_cast<size_t>(direction)];
}

int ConfusionHeuristic::Next(const std::vector<bool>& visited) const {
  for (const int direction : order_) {
    if (!visited[static_cast<size_t>(direction)]) return direction;
  }
  return -1;
}

ViewCriterion ConfusionHeuristicView(const std::map<std::string, const ConfusionModel*>& models) {
  std::map<std::string, Judged> judged;
  for (const auto& [id, model] : models) judged.insert({id, {model, ConfusionHeuristic(*model)}});
  return {"confusion_heuristic", "false reports fewer", [judged](const PlanningState& state) {
            return Gains(state, judged);
          }};
}

}  // namespace vantage
