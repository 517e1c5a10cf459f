#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/camera_model.h"
#include "common/result.h"
#include "drivers/sim/sensor_parameters.h"
#include "perception/estimator/pose_estimator.h"
#include "perception/model/object_model.h"
#include "perception/ppf/ppf_estimator.h"
#include "perception/shot/shot_estimator.h"

namespace vantage {

/// How one object is looked at in a trial (paper 6.2): by itself in front of a wall that the camera
/// looks at squarely, so that nothing but the object tells the camera's roll.
struct TrialParameters {
  std::string estimator = "ppf";   ///< or "shot"
  PpfEstimatorParameters ppf;      ///< of "ppf"
  ShotEstimatorParameters shot;    ///< of "shot"
  SensorModelParameters sensor;    ///< seed and device_id are each trial's own
  CameraModel camera;              ///< the whole image; trials see a window of it
  double nearest_distance = 0.6;   ///< m, camera to center, uniform from here (as in evaluations)
  double farthest_distance = 0.9;  ///< m, up to here
  double aim_jitter = 0.03;        ///< m, as in SimulatedViewParameters

  Result<void> Validate() const;
};

/// Simulated single views of one model through the sensor model and the real estimator. Not for
/// several threads at once.
class TrialSimulator {
 public:
  /// Trains the model. Errors: parameters, an estimator of no such name, a model that can't be
  /// trained.
  static Result<std::unique_ptr<TrialSimulator>> Create(const ObjectModel& model,
                                                        const TrialParameters& parameters);
  ~TrialSimulator();

  /// What the estimator finds (the best hypothesis' q_camera_object) when the object is in this
  /// orientation, both for the camera aimed at the object's center (see AimedAt); nothing when it
  /// finds none. Distance, aim, noise and the device's bias are drawn
  /// from `seed` alone: the same on every call, whatever was asked for before.
  std::optional<Eigen::Quaterniond> Detect(const Eigen::Quaterniond& q_camera_object,
                                           uint64_t seed);

 private:
  struct Parts;
  explicit TrialSimulator(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// ContingencyKey::estimator_parameters and ContingencyKey::sensor of trials: everything that a
/// table depends on beside the model, in lines that a person can read.
std::string EstimatorText(const TrialParameters& parameters);
std::string SensorText(const TrialParameters& parameters);

}  // namespace vantage
