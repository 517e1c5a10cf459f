#pragma once

#include "perception/calibration/target_detector.h"

namespace vantage {

/// ChArUco boards, by OpenCV's aruco module: the markers tell which inner corner is which.
class CharucoDetector : public TargetDetector {
 public:
  /// @param target valid.
  explicit CharucoDetector(const CalibrationTarget& target);

  std::vector<TargetPoint> Detect(const GrayImage& image) override;

 private:
  CalibrationTarget target_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace vantage
