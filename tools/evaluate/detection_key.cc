#include "tools/evaluate/detection_key.h"

#include <array>
#include <cstring>

#include "common/format.h"
#include "common/parameter_text.h"
#include "drivers/sim/sensor_text.h"
#include "perception/estimator/estimator_text.h"
#include "tools/support/hash.h"

// Parameters are taken apart by structured bindings: a new one does not compile until it is listed.

namespace vantage {
namespace {

uint64_t HashSamples(const ObjectModel& model) {
  uint64_t hash = Fnv1a({});
  for (const SurfacePoint& point : model.samples) {
    for (const Eigen::Vector3f* vector : {&point.position, &point.normal}) {
      std::array<char, 3 * sizeof(float)> bytes{};
      std::memcpy(bytes.data(), vector->data(), bytes.size());
      hash = Fnv1a({bytes.data(), bytes.size()}, hash);
    }
  }
  return hash;
}

void AddModel(const ObjectModel& model, ParameterText* key) {
  key->Line("model", model.id);
  key->Line("mesh", Format("%016jx", static_cast<uintmax_t>(model.mesh_hash)));
  key->Line("samples", Format("%016jx", static_cast<uintmax_t>(HashSamples(model))));
  key->Line("center", model.center.x(), model.center.y(), model.center.z());
  key->Line("diameter", model.diameter);
  const auto& [kind, elements, axis, flips] = model.symmetry;
  if (kind == SymmetryGroup::Kind::kContinuous) {
    key->Line("symmetry continuous", axis.x(), axis.y(), axis.z(), flips);
    return;
  }
  key->Line("symmetry finite", elements.size());
  for (const Eigen::Quaterniond& q : elements) key->Line("element", q.w(), q.x(), q.y(), q.z());
}

void AddViews(SequenceKind kind, const SimulatedViewParameters& parameters, ParameterText* key) {
  const auto& [circle_views,
               circle_elevation_deg,
               circle_distance,
               random_views,
               lowest_elevation_deg,
               highest_elevation_deg,
               nearest_distance,
               farthest_distance,
               aim_jitter] = parameters;
  if (kind == SequenceKind::kCircle) {
    key->Line("circle", circle_views, circle_elevation_deg, circle_distance);
    return;
  }
  key->Line("random",
            random_views,
            lowest_elevation_deg,
            highest_elevation_deg,
            nearest_distance,
            farthest_distance,
            aim_jitter);
}

}  // namespace

std::string DetectionKey(const ObjectModel& model,
                         SequenceKind kind,
                         const SimulationParameters& parameters) {
  const auto& [seed, views, camera, sensor, estimator] = parameters;
  ParameterText key;
  key.Line("version", kDetectionsVersion);
  AddModel(model, &key);
  key.Line("seed", seed);
  AddViews(kind, views, &key);
  AddCamera(camera, &key);
  AddSensor(sensor, &key);
  AddEstimator(estimator, &key);
  return key.text();
}

}  // namespace vantage
