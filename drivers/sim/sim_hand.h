#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// The hand of the simulated robot: where its camera truly sits, and how well the robot knows where
/// the hand is.
struct SimHandParameters {
  Pose T_hand_camera = Pose::Identity();
  double translation_sigma = 0.0;  ///< m, along each axis, of where the robot believes the hand
  double rotation_sigma = 0.0;     ///< rad, about each axis
  uint64_t seed = 1;

  /// Offset within 10 m, sigmas in 0..0.1 m and 0..0.1 rad.
  Result<void> Validate() const;
};

/// A robot errs by its joints' calibration: the same in the same place always, otherwise in places
/// some centimetres or degrees away. So the error is a smooth random field over the hand's poses.
class SimHand {
 public:
  explicit SimHand(const SimHandParameters& parameters);

  /// The camera's true pose, to where the robot believes the hand.
  [[nodiscard]] Pose Believed(const Pose& T_world_camera) const;
  /// Where the camera must be for the hand to be there.
  [[nodiscard]] Pose CameraAt(const Pose& T_base_hand) const {
    return T_base_hand * parameters_.T_hand_camera;
  }

 private:
  static constexpr int kWaves = 12;
  struct Wave {
    Eigen::Vector3d of_place;                // rad/m
    std::array<Eigen::Vector3d, 3> of_axes;  // rad, of the hand's axes
    double phase;                            // rad
  };

  SimHandParameters parameters_;
  std::array<std::array<Wave, kWaves>, 6> waves_;  // Of rotation vector and translation.
};

}  // namespace vantage
