#include "tools/evaluate/simulated_sequence.h"

#include <utility>

#include "common/format.h"
#include "tools/support/hash.h"

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

SimulatedStage SequenceSimulator::Place(const SimulatedViews& views, uint64_t seed) const {
  SensorModelParameters device = parameters_.sensor;
  device.seed = MixBits(seed + kNoise);
  device.device_id = MixBits(seed + kDevice);
  return {seed,
          views.T_world_object,
          SceneRenderer(SceneOf(model_, views), parameters_.camera),
          SensorModel(device, parameters_.camera)};
}

DetectedView SequenceSimulator::Look(const Pose& T_world_camera,
                                     int view,
                                     SimulatedStage* stage,
                                     SimulationTimes* times) {
  Lap lap(times);
  const RenderedView& ideal = stage->renderer.Render(T_world_camera);
  lap.To(&SimulationTimes::render);
  stage->sensor.Measure(ideal, view, kSecondsPerView * view, &depth_);
  lap.To(&SimulationTimes::sensor);
  Rng estimator_rng(stage->seed, kFirstEstimate + static_cast<uint64_t>(view));
  const PoseEstimator::Output& output = estimator_->Estimate(
      depth_, parameters_.camera, estimator_rng, times != nullptr ? &times->estimator : nullptr);
  return {T_world_camera,
          OfTheObject(output.detections,
                      T_world_camera.inverse(Eigen::Isometry) * stage->T_world_object)};
}

DetectionSequence SequenceSimulator::Simulate(SequenceKind kind,
                                              int index,
                                              SimulationTimes* times) {
  const uint64_t seed = SequenceSeed(parameters_.seed, model_.id, kind, index);
  Lap lap(times);
  Rng rng(seed, kViews);
  const SimulatedViews views = MakeSimulatedViews(
      model_, kind, index, parameters_.views, parameters_.camera, parameters_.sensor.nearest, rng);
  SimulatedStage stage = Place(views, seed);
  lap.To(&SimulationTimes::setup);

  DetectionSequence sequence{model_.id, index, views.T_world_object, {}};
  for (size_t view = 0; view < views.T_world_camera.size(); ++view) {
    sequence.views.push_back(
        Look(views.T_world_camera[view], static_cast<int>(view), &stage, times));
  }
  return sequence;
}

}  // namespace vantage
