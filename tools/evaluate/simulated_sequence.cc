#include "tools/evaluate/simulated_sequence.h"

#include <utility>

#include "common/format.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_model.h"
#include "tools/evaluate/detection_hash.h"

namespace vantage {
namespace {

constexpr double kSecondsPerView = 3.0;  // What an arm takes from one view to the next.
constexpr double kFloorHeight = -0.7;    // m
constexpr double kFloorSize = 6.0;       // m

// Streams of one sequence's random numbers.
enum Stream : uint64_t { kViews = 1, kNoise, kDevice, kFirstEstimate };

// Gives the seconds since the last call to a part.
class Lap {
 public:
  explicit Lap(SimulationTimes* times)
      : times_(times != nullptr && times->estimator.clock ? times : nullptr) {
    if (times_ != nullptr) last_ = times_->estimator.clock();
  }
  void To(double SimulationTimes::*part) {
    if (times_ == nullptr) return;
    const double now = times_->estimator.clock();
    if (part != nullptr) times_->*part += now - last_;
    last_ = now;
  }

 private:
  SimulationTimes* times_;
  double last_ = 0.0;
};

SimScene SceneOf(const ObjectModel& model, const SimulatedViews& views) {
  SimScene scene;
  SimPlane table;
  table.size *= views.scale;
  scene.table = table;
  scene.floor = SimPlane{kFloorHeight, {kFloorSize, kFloorSize}, {0.0, 0.0}};
  scene.objects.push_back({model.id, model.mesh, views.T_world_object});
  return scene;
}

}  // namespace

Result<void> SimulationParameters::Validate() const {
  for (const Result<void>& valid :
       {views.Validate(), camera.Validate(), sensor.Validate(), estimator.Validate()}) {
    if (!valid) return valid;
  }
  return {};
}

uint64_t SequenceSeed(uint64_t seed, const std::string& model_id, SequenceKind kind, int index) {
  return MixBits(Fnv1a(Format(
      "%ju/%s/%s/%d", static_cast<uintmax_t>(seed), model_id.c_str(), Name(kind).c_str(), index)));
}

Result<std::unique_ptr<SequenceSimulator>> SequenceSimulator::Create(
    const ObjectModel& model, const SimulationParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  Result<std::unique_ptr<PoseEstimator>> estimator =
      CreatePpfEstimator(std::vector<ObjectModel>{model}, parameters.estimator);
  if (!estimator) return estimator.error();
  return std::unique_ptr<SequenceSimulator>(
      new SequenceSimulator(model, parameters, std::move(estimator).value()));
}

SequenceSimulator::SequenceSimulator(const ObjectModel& model,
                                     const SimulationParameters& parameters,
                                     std::unique_ptr<PoseEstimator> estimator)
    : model_(model), parameters_(parameters), estimator_(std::move(estimator)) {}

// The hypotheses of the cluster whose best is nearest to the object, none when that is farther off
// than half the diameter and so of something else.
std::vector<Detection> SequenceSimulator::OfTheObject(const std::vector<Detection>& all,
                                                      const Pose& T_camera_object) const {
  const Eigen::Vector3d center = T_camera_object * model_.center;
  double nearest = 0.5 * model_.diameter;
  std::vector<Detection> found;
  for (size_t i = 0, end = 0; i < all.size(); i = end) {
    while (end < all.size() && all[end].cluster == all[i].cluster) ++end;
    const double distance = (all[i].T_camera_object * model_.center - center).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    found.assign(all.begin() + static_cast<std::ptrdiff_t>(i),
                 all.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return found;
}

DetectionSequence SequenceSimulator::Simulate(SequenceKind kind,
                                              int index,
                                              SimulationTimes* times) {
  const uint64_t seed = SequenceSeed(parameters_.seed, model_.id, kind, index);
  Lap lap(times);
  Rng rng(seed, kViews);
  const SimulatedViews views = MakeSimulatedViews(
      model_, kind, index, parameters_.views, parameters_.camera, parameters_.sensor.nearest, rng);
  SceneRenderer renderer(SceneOf(model_, views), parameters_.camera);
  SensorModelParameters device = parameters_.sensor;
  device.seed = MixBits(seed + kNoise);
  device.device_id = MixBits(seed + kDevice);
  SensorModel sensor(device, parameters_.camera);
  lap.To(&SimulationTimes::setup);

  DetectionSequence sequence{model_.id, index, views.T_world_object, {}};
  DepthImage depth;
  for (size_t view = 0; view < views.T_world_camera.size(); ++view) {
    const Pose& T_world_camera = views.T_world_camera[view];
    const RenderedView& ideal = renderer.Render(T_world_camera);
    lap.To(&SimulationTimes::render);
    const double time = kSecondsPerView * static_cast<double>(view);
    sensor.Measure(ideal, static_cast<int64_t>(view), time, &depth);
    lap.To(&SimulationTimes::sensor);
    Rng estimator_rng(seed, kFirstEstimate + view);
    const PoseEstimator::Output& output = estimator_->Estimate(
        depth, parameters_.camera, estimator_rng, times != nullptr ? &times->estimator : nullptr);
    lap.To(nullptr);
    sequence.views.push_back(
        {T_world_camera,
         OfTheObject(output.detections,
                     T_world_camera.inverse(Eigen::Isometry) * views.T_world_object)});
  }
  return sequence;
}

}  // namespace vantage
