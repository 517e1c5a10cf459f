#include "tools/contingency/trial_simulator.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "common/detection.h"
#include "common/format.h"
#include "common/parameter_text.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_model.h"
#include "drivers/sim/sensor_text.h"
#include "perception/estimator/estimator_text.h"
#include "tools/contingency/trial_scene.h"

namespace vantage {
namespace {

// Streams of one trial's random numbers.
enum Stream : uint64_t { kPlace = 1, kDevice, kEstimator };

// Looks for planes in windows as densely as in the whole image.
template <class Parameters>
Parameters ForWindows(Parameters parameters, const CameraModel& camera) {
  int& grid_px = parameters.estimation.segmentation.plane.grid_px;
  if (grid_px == 0) grid_px = std::max(1, camera.width / 80);
  return parameters;
}

Result<std::unique_ptr<PoseEstimator>> CreateEstimator(const ObjectModel& model,
                                                       const TrialParameters& parameters) {
  if (parameters.estimator == "shot") {
    return CreateShotEstimator({model}, ForWindows(parameters.shot, parameters.camera));
  }
  return CreatePpfEstimator(std::vector<ObjectModel>{model},
                            ForWindows(parameters.ppf, parameters.camera));
}

uint64_t Draw64(Rng& rng) {
  const uint64_t high = rng.NextUint32();
  return high << 32U | rng.NextUint32();
}

// The camera that sees but a window.
CameraModel WindowOf(const CameraModel& camera, const PixelWindow& window) {
  CameraModel part = camera;
  part.width = window.width();
  part.height = window.height();
  part.cx -= window.u0;
  part.cy -= window.v0;
  return part;
}

}  // namespace

Result<void> TrialParameters::Validate() const {
  if (estimator != "ppf" && estimator != "shot") {
    return Error{ErrorCode::kInvalidArgument,
                 Format("trials: estimator \"%s\", expected ppf or shot", estimator.c_str())};
  }
  const Result<void> estimator_valid = estimator == "ppf" ? ppf.Validate() : shot.Validate();
  for (const Result<void>& valid : {estimator_valid, sensor.Validate(), camera.Validate()}) {
    if (!valid) return valid;
  }
  struct Bound {
    const char* name;
    double value, lowest, highest;
  };
  const Bound bounds[] = {
      {"nearest_distance", nearest_distance, 0.1, 10.0},
      {"farthest_distance", farthest_distance, nearest_distance, 10.0},
      {"aim_jitter", aim_jitter, 0.0, 0.05},
  };
  for (const Bound& bound : bounds) {
    if (!(bound.value >= bound.lowest && bound.value <= bound.highest)) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("trials: %s = %g, expected %g to %g",
                          bound.name,
                          bound.value,
                          bound.lowest,
                          bound.highest)};
    }
  }
  return {};
}

struct TrialSimulator::Parts {
  Parts(const ObjectModel& model,
        const TrialParameters& parameters,
        std::unique_ptr<PoseEstimator> made)
      : center(model.center),
        diameter(model.diameter),
        camera(parameters.camera),
        scene(model, parameters),
        renderer(scene.Scene(model), camera),
        sensor(parameters.sensor, camera),
        estimator(std::move(made)) {}

  Eigen::Vector3d center;  // m, object frame
  double diameter;         // m
  CameraModel camera;
  TrialScene scene;
  SceneRenderer renderer;
  SensorModel sensor;
  std::unique_ptr<PoseEstimator> estimator;
  DepthImage depth;
};

Result<std::unique_ptr<TrialSimulator>> TrialSimulator::Create(const ObjectModel& model,
                                                               const TrialParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  Result<std::unique_ptr<PoseEstimator>> estimator = CreateEstimator(model, parameters);
  if (!estimator) return estimator.error();
  return std::unique_ptr<TrialSimulator>(
      new TrialSimulator(std::make_unique<Parts>(model, parameters, std::move(estimator).value())));
}

TrialSimulator::TrialSimulator(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
TrialSimulator::~TrialSimulator() = default;

std::optional<Eigen::Quaterniond> TrialSimulator::Detect(const Eigen::Quaterniond& q_camera_object,
                                                         uint64_t seed) {
  Parts& parts = *parts_;
  Rng place(seed, kPlace);
  const TrialScene::Placement placement = parts.scene.Place(q_camera_object, place);
  parts.renderer.MoveObject(0, placement.T_world_camera * placement.T_camera_object);
  const PixelWindow window = parts.scene.Window(placement);
  const RenderedView& ideal = parts.renderer.Render(placement.T_world_camera, window);
  Rng device(seed, kDevice);
  parts.sensor.SetDevice(Draw64(device));
  parts.sensor.Measure(ideal, 0, 0.0, &parts.depth);
  Rng rng(seed, kEstimator);
  const PoseEstimator::Output& output =
      parts.estimator->Estimate(parts.depth, WindowOf(parts.camera, window), rng);

  // The best of the cluster that is nearest to the object, as in simulated sequences.
  const Eigen::Vector3d center = placement.T_camera_object * parts.center;
  double nearest = 0.5 * parts.diameter;
  const Detection* found = nullptr;
  int cluster = -1;
  for (const Detection& detection : output.detections) {
    if (std::exchange(cluster, detection.cluster) == detection.cluster) continue;
    const double distance = (detection.T_camera_object * parts.center - center).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    found = &detection;
  }
  if (found == nullptr) return std::nullopt;
  const Eigen::Quaterniond q_camera_detected(found->T_camera_object.linear());
  return (placement.q_camera_aimed.conjugate() * q_camera_detected).normalized();
}

std::string EstimatorText(const TrialParameters& parameters) {
  return parameters.estimator == "shot" ? EstimatorText(parameters.shot)
                                        : EstimatorText(parameters.ppf);
}

std::string SensorText(const TrialParameters& parameters) {
  ParameterText text;
  AddCamera(parameters.camera, &text);
  AddSensor(parameters.sensor, &text);
  text.Line(
      "trials", parameters.nearest_distance, parameters.farthest_distance, parameters.aim_jitter);
  return text.text();
}

}  // namespace vantage
