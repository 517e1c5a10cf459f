#include "nodes/depth_memory.h"

#include <algorithm>
#include <utility>

#include "bus/image_conversion.h"
#include "common/format.h"

namespace vantage {

void DepthMemory::Add(const images_t& message) {
  waiting_.push_back(message);
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
}

Result<void> DepthMemory::Keep(int64_t utime,
                               const Pose& T_world_camera,
                               const CameraModel& camera) {
  if (views_.contains(utime) || views_.size() >= most_views_) return {};
  const auto found = std::ranges::find_if(
      waiting_, [utime](const images_t& message) { return message.utime == utime; });
  if (found == waiting_.end()) return {};
  Result<DepthFrame> frame = DepthFrameFromMessage(*found);
  if (!frame) return frame.error();
  if (frame->image.width != camera.width || frame->image.height != camera.height) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("the image has %d x %d px, expected the camera's %d x %d px",
                        frame->image.width,
                        frame->image.height,
                        camera.width,
                        camera.height)};
  }
  views_[utime] = {std::move(frame->image), T_world_camera};
  return {};
}

void DepthMemory::KeepOnly(const std::set<int64_t>& utimes) {
  std::erase_if(views_, [&utimes](const auto& view) { return !utimes.contains(view.first); });
}

}  // namespace vantage
