#include "drivers/sim/sim_hand.h"

#include <cmath>
#include <numbers>

#include "common/format.h"
#include "common/rng.h"

namespace vantage {
namespace {

/// Wave numbers, each component's standard deviation: after 5 cm or 10 deg the error is another.
constexpr double kPerMetre = 20.0;  // rad/m
constexpr double kPerAxis = 6.0;    // rad, by a unit of an axis's coordinate

Eigen::Vector3d NormalVector(double sigma, Rng* rng) {
  return sigma * Eigen::Vector3d(rng->Normal(), rng->Normal(), rng->Normal());
}

}  // namespace

Result<void> SimHandParameters::Validate() const {
  const double offset = T_hand_camera.translation().norm();
  if (!(offset <= 10.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("camera %g m from the hand, expected at most 10 m", offset)};
  }
  for (const double sigma : {translation_sigma, rotation_sigma}) {
    if (!(sigma >= 0.0 && sigma <= 0.1)) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("robot noise of %g, expected 0 to 0.1 m or rad", sigma)};
    }
  }
  return {};
}

SimHand::SimHand(const SimHandParameters& parameters) : parameters_(parameters) {
  Rng rng(parameters.seed, 0x68616e64);
  for (std::array<Wave, kWaves>& waves : waves_) {
    for (Wave& wave : waves) {
      wave.of_place = NormalVector(kPerMetre, &rng);
      for (Eigen::Vector3d& axis : wave.of_axes) axis = NormalVector(kPerAxis, &rng);
      wave.phase = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    }
  }
}

Pose SimHand::Believed(const Pose& T_world_camera) const {
  const Pose truth = T_world_camera * parameters_.T_hand_camera.inverse(Eigen::Isometry);
  Eigen::Matrix<double, 6, 1> error;
  for (size_t i = 0; i < waves_.size(); ++i) {
    double sum = 0.0;
    for (const Wave& wave : waves_[i]) {
      double angle = wave.phase + wave.of_place.dot(truth.translation());
      for (int j = 0; j < 3; ++j) {
        angle += wave.of_axes[static_cast<size_t>(j)].dot(truth.linear().col(j));
      }
      sum += std::cos(angle);
    }
    // The variance of a cosine is 1/2.
    error(static_cast<Eigen::Index>(i)) = sum * std::sqrt(2.0 / kWaves);
  }
  Pose believed = truth;
  believed.linear() = ExpSo3(parameters_.rotation_sigma * error.head<3>()) * truth.linear();
  believed.translation() += parameters_.translation_sigma * error.tail<3>();
  return believed;
}

}  // namespace vantage
