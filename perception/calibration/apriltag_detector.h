#pragma once

#include <memory>

#include "perception/calibration/tag_family.h"
#include "perception/calibration/target_detector.h"

struct apriltag_detector;

namespace vantage {

/// Grids of AprilTags and single ones, by libapriltag.
class AprilTagDetector : public TargetDetector {
 public:
  /// @param target valid.
  AprilTagDetector(const CalibrationTarget& target, TagFamily family);

  std::vector<TargetPoint> Detect(const GrayImage& image) override;

 private:
  CalibrationTarget target_;
  std::vector<Eigen::Vector3d> points_;
  TagFamily family_;  // Outlives the detector, which points to it.
  std::unique_ptr<apriltag_detector, void (*)(apriltag_detector*)> detector_;
};

}  // namespace vantage
