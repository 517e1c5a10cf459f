#pragma once

#include <cstdint>
#include <memory>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/result.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_model.h"
#include "drivers/sim/sensor_parameters.h"
#include "perception/ppf/ppf_estimator.h"
#include "tools/evaluate/detection_sequence.h"
#include "tools/evaluate/simulated_views.h"

namespace vantage {

/// The demo's estimator, but up to three hypotheses of an object are kept.
inline PpfEstimatorParameters WithAlternatives() {
  PpfEstimatorParameters parameters;
  parameters.estimation.hypotheses_per_cluster = 3;
  return parameters;
}

/// Every sequence has a device of its own: `sensor.seed` and `sensor.device_id` are not used.
struct SimulationParameters {
  uint64_t seed = 1;  ///< of all sequences
  SimulatedViewParameters views;
  CameraModel camera;  ///< VGA
  SensorModelParameters sensor;
  PpfEstimatorParameters estimator = WithAlternatives();

  Result<void> Validate() const;
};

/// Numbers that decide one sequence: of the seed, the model, the kind and the index alone, so that
/// any sequence can be made without the others.
uint64_t SequenceSeed(uint64_t seed, const std::string& model_id, SequenceKind kind, int index);

/// Seconds that the parts of all views of a simulator took, by the clock in `estimator`.
struct SimulationTimes {
  double setup = 0.0;   ///< scene and sensor of every sequence
  double render = 0.0;  ///< the ideal views
  double sensor = 0.0;  ///< their noise
  StageTimes estimator;
};

/// An object on its table before a device of its own: what a seed and a pose decide.
struct SimulatedStage {
  uint64_t seed = 0;
  Pose T_world_object = Pose::Identity();
  SceneRenderer renderer;
  SensorModel sensor;
};

/// Lets the estimator see one object on a table through a structured-light sensor. Not for several
/// threads at once; another simulator of the same model gives the same sequences.
class SequenceSimulator {
 public:
  /// Trains the model's table. Errors: parameters, a model that can't be trained.
  static Result<std::unique_ptr<SequenceSimulator>> Create(const ObjectModel& model,
                                                           const SimulationParameters& parameters);

  /// @param times may be null; is added to.
  DetectionSequence Simulate(SequenceKind kind, int index, SimulationTimes* times = nullptr);

  /// Puts the object before a device, to be looked at from anywhere.
  /// @param views where it lies, and by how much the table is larger; the cameras are not used.
  [[nodiscard]] SimulatedStage Place(const SimulatedViews& views, uint64_t seed) const;
  /// The view-th look, view >= 0: its noise is the same from wherever it is.
  DetectedView Look(const Pose& T_world_camera,
                    int view,
                    SimulatedStage* stage,
                    SimulationTimes* times = nullptr);

 private:
  SequenceSimulator(const ObjectModel& model,
                    const SimulationParameters& parameters,
                    std::unique_ptr<PoseEstimator> estimator);
  [[nodiscard]] std::vector<Detection> OfTheObject(const std::vector<Detection>& all,
                                                   const Pose& T_camera_object) const;

  ObjectModel model_;
  SimulationParameters parameters_;
  std::unique_ptr<PoseEstimator> estimator_;
  DepthImage depth_;  // Reused.
};

}  // namespace vantage
