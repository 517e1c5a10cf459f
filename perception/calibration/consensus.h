#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// A closed-form calibration that as many views as possible agree with.
struct Consensus {
  Pose T_x = Pose::Identity();
  Pose T_y = Pose::Identity();
  /// Of each view, which of its poses agrees: 0 T_camera_target, i > 0 other_T_camera_target[i -
  /// 1], -1 none.
  std::vector<int> chosen;
  std::string method;        ///< closed form with the least residual
  double noise_scale = 1.0;  ///< of HandEyeNoise, as the views that agree best say
};

/// Draws small subsets of views (also of their other poses), solves each in closed form, and keeps
/// what most views agree with within the noise (Fischler, Bolles 1981); there all closed forms are
/// tried and the one with the least residual is taken. The same for the same seed.
/// Errors: fewer than 3 views; no three views agree.
Result<Consensus> FindConsensus(HandEyeSetup setup,
                                std::span<const PoseView> views,
                                const HandEyeNoise& noise,
                                uint64_t seed);

}  // namespace vantage
