#include "perception/calibration/target_detector.h"

#include "perception/calibration/apriltag_detector.h"
#include "perception/calibration/charuco_detector.h"
#include "perception/calibration/chessboard_detector.h"

namespace vantage {

bool IsDetectable(const GrayImage& image) {
  constexpr int kSmallest = 16;
  constexpr int kLargest = 16384;
  return image.width >= kSmallest && image.width <= kLargest && image.height >= kSmallest &&
         image.height <= kLargest &&
         image.pixels.size() ==
             static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
}

Result<std::unique_ptr<TargetDetector>> MakeTargetDetector(const CalibrationTarget& target) {
  if (const auto valid = target.Validate(); !valid) return valid.error();
  std::unique_ptr<TargetDetector> detector;
  switch (target.kind) {
    case CalibrationTarget::Kind::kAprilTags: {
      auto family = TagFamily::Find(target.family);
      if (!family) return family.error();
      detector = std::make_unique<AprilTagDetector>(target, std::move(family).value());
      break;
    }
    case CalibrationTarget::Kind::kChessboard:
      detector = std::make_unique<ChessboardDetector>(target);
      break;
    case CalibrationTarget::Kind::kCharuco:
      detector = std::make_unique<CharucoDetector>(target);
      break;
  }
  return detector;
}

}  // namespace vantage
