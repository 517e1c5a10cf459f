#pragma once

#include <memory>
#include <vector>

#include "common/gray_image.h"
#include "common/result.h"
#include "perception/calibration/calibration_target.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// Finds a target's points in images.
class TargetDetector {
 public:
  virtual ~TargetDetector() = default;
  /// Empty where the target is not seen. Of a target of tags those that are seen; of a chessboard
  /// all or none. Any size of image.
  virtual std::vector<TargetPoint> Detect(const GrayImage& image) = 0;
};

/// Whether an image has as many pixels as it claims, and a size that detectors take: 16 to 16384 px
/// each way.
bool IsDetectable(const GrayImage& image);

/// Errors: a target that is not valid, a family or dictionary that there is not (names those that
/// there are).
Result<std::unique_ptr<TargetDetector>> MakeTargetDetector(const CalibrationTarget& target);

}  // namespace vantage
