#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perception/calibration/hand_eye.h"

namespace vantage {

/// A way to calibrate that ours is compared with.
struct HandEyeMethod {
  std::string id;
  std::string label;
  /// X; nothing where it gives up.
  std::function<std::optional<Pose>(HandEyeSetup, std::span<const PoseView>, const HandEyeNoise&)>
      calibrate;
};

/// OpenCV's calibrateHandEye (Tsai, Park, Horaud, Andreff, Daniilidis) and
/// calibrateRobotWorldHandEye (Shah, Li), and one Ceres problem over all views with a Cauchy loss,
/// started from Park and Martin.
std::vector<HandEyeMethod> HandEyePeers();

}  // namespace vantage
