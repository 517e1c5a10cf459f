#include "fusion/tracker_state.h"

#include <utility>

#include "common/format.h"
#include "fusion/state_text.h"

namespace vantage {
namespace {

std::string FormatKey(const SetKey& key) {
  return Format("%lld %lld ", static_cast<long long>(key.seq), static_cast<long long>(key.utime)) +
         FormatName(key.channel);
}

SetKey ReadKey(StateReader& reader) {
  SetKey key;
  key.seq = reader.Number<int64_t>(INT64_MIN, INT64_MAX);
  key.utime = reader.Number<int64_t>(INT64_MIN, INT64_MAX);
  key.channel = reader.Name();
  return key;
}

Instance ReadInstance(StateReader& reader, const TrackerState& state) {
  Instance instance;
  const int previous = state.instances.empty() ? -1 : state.instances.back().id;
  reader.Keyword("instance");
  instance.id = reader.Number<int>(previous + 1, state.next_id - 1);
  const size_t num_observations = reader.Count();
  instance.model_id = reader.Name();
  if (num_observations == 0) reader.Fail("an observation of every instance");
  int next_viewpoint = 0;
  for (size_t i = 0; i < num_observations && !reader.failed(); ++i) {
    Observation observation;
    reader.Keyword("observation");
    observation.viewpoint =
        reader.Number<int>(next_viewpoint, static_cast<int>(state.viewpoints.size()) - 1);
    next_viewpoint = observation.viewpoint + 1;
    observation.index = reader.Number<int>(0, INT32_MAX);
    observation.mse = reader.Real();
    if (observation.mse < 0.0) reader.Fail("a mean squared error of 0 or more");
    observation.verification_score = reader.Real();
    observation.T_world_object = reader.RigidPose();
    observation.source = ReadKey(reader);
    instance.observations.push_back(std::move(observation));
  }
  return instance;
}

}  // namespace

std::string FormatTrackerState(const TrackerState& state) {
  std::string text = Format("viewpoints %zu\n", state.viewpoints.size());
  for (const Viewpoint& viewpoint : state.viewpoints) {
    text +=
        Format("viewpoint %d", viewpoint.num_sets) + FormatPose(viewpoint.T_world_camera) + "\n";
  }
  text += Format("sets %zu\n", state.recent_sets.size());
  for (const SetKey& key : state.recent_sets) text += "set " + FormatKey(key) + "\n";
  text += Format("next_id %d\ninstances %zu\n", state.next_id, state.instances.size());
  for (const Instance& instance : state.instances) {
    text += Format("instance %d %zu ", instance.id, instance.observations.size()) +
            FormatName(instance.model_id) + "\n";
    for (const Observation& observation : instance.observations) {
      text += Format("observation %d %d ", observation.viewpoint, observation.index) +
              FormatReal(observation.mse) + " " + FormatReal(observation.verification_score) +
              FormatPose(observation.T_world_object) + " " + FormatKey(observation.source) + "\n";
    }
  }
  return text;
}

Result<TrackerState> ParseTrackerState(const std::string& text) {
  StateReader reader(text);
  TrackerState state;
  reader.Keyword("viewpoints");
  const size_t num_viewpoints = reader.Count();
  for (size_t i = 0; i < num_viewpoints && !reader.failed(); ++i) {
    reader.Keyword("viewpoint");
    Viewpoint viewpoint;
    viewpoint.num_sets = reader.Number<int>(0, INT32_MAX);
    viewpoint.T_world_camera = reader.RigidPose();
    state.viewpoints.push_back(viewpoint);
  }
  reader.Keyword("sets");
  const size_t num_sets = reader.Count();
  for (size_t i = 0; i < num_sets && !reader.failed(); ++i) {
    reader.Keyword("set");
    state.recent_sets.push_back(ReadKey(reader));
  }
  reader.Keyword("next_id");
  state.next_id = reader.Number<int>(0, INT32_MAX);
  reader.Keyword("instances");
  const size_t num_instances = reader.Count();
  for (size_t i = 0; i < num_instances && !reader.failed(); ++i) {
    state.instances.push_back(ReadInstance(reader, state));
  }
  reader.End();
  if (reader.failed()) return Error{ErrorCode::kCorrupt, reader.error()};
  return state;
}

}  // namespace vantage
