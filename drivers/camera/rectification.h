#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/camera_intrinsics.h"
#include "common/result.h"
#include "drivers/camera/camera_calibration.h"
#include "drivers/camera/camera_device.h"
#include "drivers/camera/camera_frame.h"
#include "drivers/camera/color_registration.h"
#include "drivers/camera/depth_registration.h"
#include "drivers/camera/undistortion.h"

namespace vantage {

/// Makes the images of a stream those of ideal pinhole cameras, and moves one camera's into the
/// other's frame where that was asked for, as far as the calibration goes.
class Rectification {
 public:
  /// Errors: images of another size than the calibrated ones; fields of view that are none.
  static Result<Rectification> Create(const StreamDetails& details,
                                      const StreamRequest& request,
                                      const std::optional<CameraCalibration>& calibration);

  /// From images as the device gave them, of the size that `details` told. Sets all that a frame
  /// says of its geometry. Returns what is wrong with the frame, in one sentence; empty when all is
  /// well.
  std::string Apply(CameraFrame* frame);

  /// What is lacking, in one sentence; empty when all is there.
  [[nodiscard]] const std::string& note() const { return note_; }

 private:
  Rectification() = default;

  Result<void> FindModel(const StreamDetails& details,
                         const std::optional<CameraCalibration>& calibration);
  void AddNote(const std::string& sentence);
  void PlanRegistration(const StreamDetails& details,
                        const StreamRequest& request,
                        const std::optional<CameraCalibration>& calibration);
  void PlanUndistortion(const StreamDetails& details,
                        const StreamRequest& request,
                        const std::optional<CameraCalibration>& calibration);
  std::string RectifyColor(CameraFrame* frame);

  std::string note_;
  int width_ = 0;   // px, of the frames that come out, as what follows.
  int height_ = 0;  // px
  std::optional<CameraModel> model_;
  bool registered_ = false;
  std::vector<int32_t> depth_map_;         // Empty: depth is not undistorted.
  std::optional<CameraIntrinsics> color_;  // Of color images as they come; nothing: not known.
  std::optional<ImageUndistortion> color_undistortion_;
  std::optional<DepthRegistration> depth_to_color_;
  std::optional<ColorRegistration> color_to_depth_;
};

}  // namespace vantage
