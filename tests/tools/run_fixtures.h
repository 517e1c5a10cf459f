#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/so3.h"
#include "perception/model/object_model.h"
#include "tools/support/recorded_run.h"

namespace vantage {

/// The first image of every run that tests make up, us since the epoch.
inline constexpr int64_t kRunStart = 1'700'000'000'000'000;

/// A model of which only what judging needs is there.
inline ObjectModel PlainModel(const std::string& id,
                              const Eigen::Vector3d& center,
                              double diameter,
                              const SymmetryGroup& symmetry = SymmetryGroup::None()) {
  ObjectModel model;
  model.id = id;
  model.center = center;
  model.diameter = diameter;
  model.symmetry = symmetry;
  return model;
}

/// A pose that is off by `angle` rad about the model's center and by `shift` m.
inline Pose OffBy(const Pose& T_world_truth,
                  const ObjectModel& model,
                  double angle,
                  const Eigen::Vector3d& shift,
                  const Eigen::Vector3d& axis = Eigen::Vector3d(0.6, 0.0, 0.8)) {
  Pose turn = Pose::Identity();
  turn.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  Pose T_world_estimate = T_world_truth * Eigen::Translation3d(model.center) * turn *
                          Eigen::Translation3d(-model.center);
  T_world_estimate.pretranslate(shift);
  return T_world_estimate;
}

/// One object of OBJECTS, confirmed, with one peak.
inline object_estimate_v3_t EstimateAt(int32_t instance,
                                       const std::string& model_id,
                                       const Pose& T_world_object) {
  object_estimate_v3_t object{};
  object.instance_id = instance;
  object.model_id = model_id;
  object.state = object_estimate_v3_t::CONFIRMED;
  for (Eigen::Index i = 0; i < 3; ++i) object.trans[i] = T_world_object.translation()[i];
  const Eigen::Quaterniond q(T_world_object.linear());
  orientation_peak_v2_t peak{};
  peak.quat[0] = q.w();
  peak.quat[1] = q.x();
  peak.quat[2] = q.y();
  peak.quat[3] = q.z();
  peak.weight = 1.0;
  object.peaks.push_back(peak);
  object.num_peaks = 1;
  object.num_views = 1;
  object.last_change = -1.0;
  return object;
}

/// OBJECTS with its counts filled in.
inline object_estimates_v3_t ObjectsOf(std::vector<object_estimate_v3_t> objects,
                                       int32_t num_viewpoints,
                                       int64_t utime) {
  object_estimates_v3_t message{};
  message.utime = utime;
  message.num_viewpoints = num_viewpoints;
  message.num_objects = static_cast<int32_t>(objects.size());
  message.objects = std::move(objects);
  return message;
}

/// Adds a source to an estimate.
inline void AddSource(const std::string& channel,
                      int64_t seq,
                      int32_t index,
                      int32_t viewpoint,
                      object_estimate_v3_t* object) {
  detection_source_t source{};
  source.channel = channel;
  source.seq = seq;
  source.index = index;
  source.viewpoint = viewpoint;
  object->sources.push_back(source);
  object->num_sources = static_cast<int32_t>(object->sources.size());
}

/// A viewpoint of a run: image `second` s after the first.
inline RunView ViewOf(double second, std::vector<object_estimate_v3_t> objects, int32_t viewpoint) {
  RunView view;
  view.utime = kRunStart + static_cast<int64_t>(1e6 * second);
  view.objects = ObjectsOf(std::move(objects), viewpoint + 1, view.utime);
  return view;
}

}  // namespace vantage
