#include "fusion/tracker_state.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

// Hexadecimal floating point is exact.
std::string FormatNumber(double value) { return Format("%a", value); }

// With its length, since names may hold any character.
std::string FormatName(const std::string& name) { return Format("%zu:", name.size()) + name; }

std::string FormatPose(const Pose& pose) {
  std::string text;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) {
      text.append(" ").append(FormatNumber(pose.matrix()(row, column)));
    }
  }
  return text;
}

std::string FormatKey(const SetKey& key) {
  return Format("%lld %lld ", static_cast<long long>(key.seq), static_cast<long long>(key.utime)) +
         FormatName(key.channel);
}

// Takes a state's text apart; once something is not as expected, all that follows is 0 or empty.
class StateReader {
 public:
  explicit StateReader(std::string_view text) : text_(text) {}

  void Keyword(std::string_view keyword) {
    if (Word() != keyword) Fail(Format("\"%s\"", std::string(keyword).c_str()));
  }

  template <class Integer>
  Integer Number(Integer lowest, Integer highest) {
    const std::string_view word = Word();
    Integer value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < lowest ||
        value > highest) {
      Fail("a number in its range");
      return Integer{};
    }
    return value;
  }

  // A count of records, each of at least a line.
  size_t Count() {
    return static_cast<size_t>(Number<int64_t>(0, static_cast<int64_t>(text_.size())));
  }

  double Real() {
    const std::string word(Word());
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0' || !std::isfinite(value)) {
      Fail("a finite number");
      return 0.0;
    }
    return value;
  }

  std::string Name() {
    SkipSpace();
    const size_t colon = text_.find(':', position_);
    size_t length = 0;
    if (colon != std::string_view::npos) {
      const auto [end, error] =
          std::from_chars(text_.data() + position_, text_.data() + colon, length);
      if (error == std::errc() && end == text_.data() + colon &&
          length <= text_.size() - colon - 1) {
        position_ = colon + 1 + length;
        return std::string(text_.substr(colon + 1, length));
      }
    }
    Fail("a name with its length");
    return {};
  }

  Pose RigidPose() {
    Pose pose = Pose::Identity();
    for (Eigen::Index row = 0; row < 3; ++row) {
      for (Eigen::Index column = 0; column < 4; ++column) pose.matrix()(row, column) = Real();
    }
    const Eigen::Matrix3d R = pose.linear();
    if (!((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3)) {
      Fail("a rigid transform");
    }
    return pose;
  }

  SetKey Key() {
    SetKey key;
    key.seq = Number<int64_t>(INT64_MIN, INT64_MAX);
    key.utime = Number<int64_t>(INT64_MIN, INT64_MAX);
    key.channel = Name();
    return key;
  }

  void End() {
    SkipSpace();
    if (position_ != text_.size()) Fail("the end");
  }

  void Fail(const std::string& expected) {
    if (!error_.empty()) return;
    size_t line = 1;
    for (size_t i = 0; i < position_ && i < text_.size(); ++i) line += text_[i] == '\n' ? 1 : 0;
    error_ = Format("line %zu: expected %s", line, expected.c_str());
  }

  [[nodiscard]] bool failed() const { return !error_.empty(); }
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  static bool IsSpace(char c) { return c == ' ' || c == '\n'; }

  void SkipSpace() {
    while (position_ < text_.size() && IsSpace(text_[position_])) ++position_;
  }

  std::string_view Word() {
    if (failed()) return {};
    SkipSpace();
    const size_t begin = position_;
    while (position_ < text_.size() && !IsSpace(text_[position_])) ++position_;
    return text_.substr(begin, position_ - begin);
  }

  std::string_view text_;
  size_t position_ = 0;
  std::string error_;
};

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
    observation.source = reader.Key();
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
              FormatNumber(observation.mse) + " " + FormatNumber(observation.verification_score) +
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
    state.recent_sets.push_back(reader.Key());
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
