#pragma once

#include "perception/calibration/target_detector.h"

namespace vantage {

/// Chessboards, by OpenCV's detector of Duda and Frese, "Accurate Detection and Localization of
/// Checkerboard Corners for Calibration", BMVC 2018.
class ChessboardDetector : public TargetDetector {
 public:
  /// @param target valid.
  explicit ChessboardDetector(const CalibrationTarget& target);

  std::vector<TargetPoint> Detect(const GrayImage& image) override;

 private:
  CalibrationTarget target_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace vantage
