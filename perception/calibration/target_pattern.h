#pragma once

#include <vector>

#include "perception/calibration/calibration_target.h"

namespace vantage {

/// An axis-parallel part of a target, m in the target's frame.
struct TargetRectangle {
  Eigen::Vector2d lowest = Eigen::Vector2d::Zero();
  Eigen::Vector2d highest = Eigen::Vector2d::Zero();
};

/// What is black on a target, without overlaps. @param target valid.
std::vector<TargetRectangle> BlackParts(const CalibrationTarget& target);

}  // namespace vantage
