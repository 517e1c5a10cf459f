#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "perception/calibration/calibration_target.h"
#include "perception/calibration/hand_eye.h"
#include "perception/calibration/hand_trajectory.h"
#include "perception/calibration/input_mistakes.h"
#include "perception/calibration/raw_pose.h"
#include "perception/calibration/target_detector.h"
#include "tools/handeye/image_folder.h"
#include "tools/handeye/intrinsics_file.h"

namespace vantage {

/// What a calibration is made of: poses, or points in images.
struct CalibrationInput {
  InputSource source = InputSource::kPosesAndPoses;
  /// All views as they were written; of images with the better pose of the target.
  std::vector<RawView> raw;
  std::vector<PoseView> poses;    ///< of poses and of detections
  std::vector<ImageView> images;  ///< of images
  std::optional<CameraIntrinsics> intrinsics;
  HandTrajectory trajectory;       ///< of a log; empty otherwise
  std::vector<std::string> notes;  ///< what was left out and why, a sentence each
};

/// Makes views of pairs of poses. Errors: rows that are no poses, the first of them named, with the
/// reading under which they would be, where there is one.
Result<CalibrationInput> InputFromPoses(HandEyeSetup setup,
                                        std::vector<RawView> views,
                                        uint64_t seed);

/// An image with its name.
struct NamedImage {
  std::string name;
  int64_t utime = 0;
  RawPose hand;
  GrayImage image;
};

/// Finds the target in images, one after another, so that only one is held at a time.
class ImageInput {
 public:
  /// Errors: as MakeTargetDetector().
  static Result<ImageInput> Make(const CalibrationTarget& target,
                                 const CameraIntrinsics& intrinsics,
                                 double pixel_sigma);
  /// Errors: the image is not of the size that the intrinsics are for; the hand's pose is none.
  Result<void> Add(const NamedImage& image);
  [[nodiscard]] bool HasImages() const { return num_images_ > 0; }
  /// Errors: the target was seen in no image.
  Result<CalibrationInput> Finish();

 private:
  std::unique_ptr<TargetDetector> detector_;
  CalibrationTarget target_;
  CalibrationInput input_;
  std::vector<int> seen_tags_;  // That are not of the target.
  double pixel_sigma_ = 0.2;
  size_t num_images_ = 0;
};

/// The images of a folder. Errors: as ReadImageFolder(), ReadGrayImage() and ImageInput.
Result<CalibrationInput> InputFromFolder(const ImageFolderLayout& layout,
                                         const CalibrationTarget& target,
                                         const CameraIntrinsics& intrinsics,
                                         double pixel_sigma);

}  // namespace vantage
