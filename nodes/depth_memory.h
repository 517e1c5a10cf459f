#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/result.h"
#include "common/so3.h"
#include "vantage/images_t.hpp"

namespace vantage {

/// Depth images of one camera that detections rest on, kept for the refinement of poses over
/// several of them. What comes waits undecoded until detections of its time tell whether it is of
/// use.
class DepthMemory {
 public:
  struct View {
    DepthImage depth;  ///< m
    Pose T_world_camera = Pose::Identity();
  };

  /// Images that wait at most; detections come within a second or not at all.
  static constexpr size_t kMostWaiting = 40;

  /// @param most_views kept at a time.
  explicit DepthMemory(size_t most_views) : most_views_(most_views) {}

  /// An image of the camera; the oldest that waits goes when there are too many.
  void Add(const images_t& message);
  /// Detections were made in the image of `utime`, taken from `T_world_camera`. Nothing where that
  /// image never came, or as many views as may be are there. Errors: as DepthFrameFromMessage(); an
  /// image of another size than the camera's.
  Result<void> Keep(int64_t utime, const Pose& T_world_camera, const CameraModel& camera);
  /// Forgets views of other times than these.
  void KeepOnly(const std::set<int64_t>& utimes);

  /// By utime of the image, us.
  [[nodiscard]] const std::map<int64_t, View>& views() const { return views_; }

 private:
  size_t most_views_;
  std::deque<images_t> waiting_;
  std::map<int64_t, View> views_;
};

}  // namespace vantage
