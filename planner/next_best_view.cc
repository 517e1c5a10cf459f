#include "planner/next_best_view.h"

#include <algorithm>
#include <array>
#include <limits>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

using Rejection = JudgedView::Rejection;

constexpr double kEqual = 1e-9;

// Why nothing can be seen from a candidate; empty when something can.
std::string HiddenReason(const PlanningState& state, size_t candidate) {
  const size_t num_objects = state.objects.size();
  if (state.visibility.empty() || num_objects == 0) return {};
  for (size_t object = 0; object < num_objects; ++object) {
    if (state.Unhidden(candidate, object) > 0.0) return {};
  }
  switch (const int occluder = state.visibility[candidate * num_objects].occluder) {
    case Visibility::kTable:
      return "occluded by the table";
    case Visibility::kImage:
      return "outside of the image";
    default:
      return "occluded by " + NameOf(state.objects[static_cast<size_t>(occluder)]);
  }
}

void Reject(JudgedView* judged, Rejection rejection, std::string reason) {
  judged->rejection = rejection;
  judged->reason = std::move(reason);
}

JudgedView Judge(const PlanningState& state, const ViewChoice& choice, size_t i) {
  JudgedView judged;
  judged.T_world_camera = state.candidates[i];
  judged.cost = (state.candidates[i].translation() - choice.T_world_camera.translation()).norm();
  const bool is_out_of_reach = !choice.out_of_reach.empty() && !choice.out_of_reach[i].empty();
  judged.reachable = !is_out_of_reach && choice.status[i].refusal.empty();
  if (choice.status[i].visited) {
    Reject(&judged, Rejection::kVisited, "visited");
  } else if (!choice.status[i].refusal.empty()) {
    Reject(&judged, Rejection::kRefused, choice.status[i].refusal);
  } else if (is_out_of_reach) {
    Reject(&judged, Rejection::kOutOfReach, choice.out_of_reach[i]);
  } else if (std::string hidden = HiddenReason(state, i); !hidden.empty()) {
    Reject(&judged, Rejection::kHidden, std::move(hidden));
  }
  return judged;
}

// The best by utility, without `excluded`; -1: none is left.
int Best(const std::vector<JudgedView>& candidates, double travel_weight, int excluded) {
  int best = -1;
  double best_utility = 0.0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const JudgedView& judged = candidates[i];
    if (judged.rejection != Rejection::kNone || static_cast<int>(i) == excluded) continue;
    const double utility = judged.gain - travel_weight * judged.cost;
    if (best >= 0) {
      const double more = utility - best_utility;
      const double best_cost = candidates[static_cast<size_t>(best)].cost;
      if (more < -kEqual || (more <= kEqual && judged.cost >= best_cost - kEqual)) continue;
    }
    best = static_cast<int>(i);
    best_utility = utility;
  }
  return best;
}

// Of all candidates that can be selected.
std::optional<double> MostInformation(const PlanningState& state,
                                      const ViewCriterion& criterion,
                                      const ViewGains& gains,
                                      const std::vector<JudgedView>& candidates) {
  if (criterion.unit != kNat || gains.by_object.empty()) return {};
  double most = 0.0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].rejection != Rejection::kNone) continue;
    double sum = 0.0;
    for (size_t object = 0; object < state.objects.size(); ++object) {
      const PlannedObject& planned = state.objects[object];
      if (planned.confusion == nullptr || planned.belief.empty()) continue;
      sum += gains.by_object[i * state.objects.size() + object];
    }
    most = std::max(most, sum);
  }
  return most;
}

// "none of the 500 views is left: 12 visited, 488 out of reach or in keep-out volumes".
std::string NoneLeft(const std::vector<JudgedView>& candidates) {
  constexpr std::array kWords = {"",
                                 "visited",
                                 "out of reach or in keep-out volumes",
                                 "refused by the robot",
                                 "with all objects hidden"};
  std::array<int, kWords.size()> counts{};
  for (const JudgedView& judged : candidates) ++counts[static_cast<size_t>(judged.rejection)];
  std::string text = Format("none of the %zu views is left", candidates.size());
  const char* separator = ": ";
  for (size_t i = 1; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    text += separator + Format("%d ", counts[i]) + kWords[i];
    separator = ", ";
  }
  return text;
}

// "expected gain 0.64 nat (filter #1 0.61, mug #2 0.03)", of the objects that bring the most.
std::string GainText(const PlanningState& state,
                     const ViewCriterion& criterion,
                     const ViewGains& gains,
                     size_t i) {
  std::string text = gains.by_object.empty() ? "gain" : "expected gain";
  text += Format(" %.2f", gains.total[i]);
  if (!criterion.unit.empty()) text += " " + criterion.unit;
  const size_t count = state.objects.size();
  if (gains.by_object.empty() || count < 2) return text;
  std::vector<size_t> order(count);
  for (size_t object = 0; object < count; ++object) order[object] = object;
  const auto part = [&](size_t object) { return gains.by_object[i * count + object]; };
  std::stable_sort(
      order.begin(), order.end(), [&](size_t a, size_t b) { return part(a) > part(b); });
  constexpr size_t kMostNamed = 4;
  for (size_t rank = 0; rank < std::min(count, kMostNamed); ++rank) {
    text += rank == 0 ? " (" : ", ";
    text += NameOf(state.objects[order[rank]]) + Format(" %.2f", part(order[rank]));
  }
  return text + (count > kMostNamed ? ", ...)" : ")");
}

}  // namespace

NextView SelectNextView(const PlanningState& state,
                        const ViewCriterion& criterion,
                        const ViewChoice& choice) {
  const ViewGains gains = criterion.gains(state);
  const size_t count = state.candidates.size();
  VANTAGE_CHECK(gains.total.size() == count && choice.status.size() == count,
                Format("%zu candidates, %zu gains, %zu states",
                       count,
                       gains.total.size(),
                       choice.status.size()));
  NextView view;
  view.criterion = criterion.name;
  for (size_t i = 0; i < count; ++i) {
    view.candidates.push_back(Judge(state, choice, i));
    view.candidates.back().gain = gains.total[i];
  }
  const double travel_weight = criterion.unit == kNat ? choice.travel_weight : 0.0;
  view.information = MostInformation(state, criterion, gains, view.candidates);
  view.selected = Best(view.candidates, travel_weight, -1);
  if (view.selected < 0) {
    view.reason = NoneLeft(view.candidates);
    return view;
  }
  const auto selected = static_cast<size_t>(view.selected);
  view.reason = Format("view %d: ", view.selected) + GainText(state, criterion, gains, selected) +
                Format(" by criterion \"%s\", %.2f m away",
                       criterion.name.c_str(),
                       view.candidates[selected].cost);
  if (const int next = Best(view.candidates, travel_weight, view.selected); next >= 0) {
    const JudgedView& runner_up = view.candidates[static_cast<size_t>(next)];
    view.reason +=
        Format("; runner-up %d with %.2f, %.2f m away", next, runner_up.gain, runner_up.cost);
  }
  return view;
}

int NearestCandidate(std::span<const Pose> candidates,
                     const Pose& T_world_camera,
                     const Eigen::Vector3d& target) {
  int nearest = -1;
  double smallest_angle = std::numeric_limits<double>::infinity();
  double smallest_distance = smallest_angle;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const double angle = AngleFromTarget(candidates[i], T_world_camera, target);
    const double distance = (candidates[i].translation() - T_world_camera.translation()).norm();
    if (angle > smallest_angle + kEqual) continue;
    if (angle > smallest_angle - kEqual && distance >= smallest_distance) continue;
    smallest_angle = angle;
    smallest_distance = distance;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace vantage
