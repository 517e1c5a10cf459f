#include "tools/support/stage_image.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "common/pose_buffer.h"
#include "vantage/camera_info_t.hpp"
#include "vantage/detections_v2_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

// What a log tells before its images are decoded.
class ImageIndex {
 public:
  ImageIndex(const std::string& camera, double rest_window_s)
      : channel_("CAMERA_" + camera), window_(static_cast<int64_t>(1e6 * rest_window_s)) {}

  void Read(const LogEvent& event) {
    if (event.channel == channel_) {
      const auto message = DecodeChecked<images_t>(event.data);
      if (message) {
        all_.push_back(message->utime);
        pending_.push_back(message->utime);
      }
    } else if (event.channel == channel_ + "_TO_WORLD") {
      const auto message = DecodeChecked<rigid_transform_t>(event.data);
      if (message) OnPose(*message);
    } else if (event.channel == channel_ + "_INFO") {
      const auto message = DecodeChecked<camera_info_t>(event.data);
      if (!message) return;
      if (const Result<CameraModel> model = CameraFromMessage(*message)) camera_ = *model;
    } else if (event.channel.starts_with("DETECTIONS_")) {
      const auto message = DecodeChecked<detections_v2_t>(event.data);
      if (!message) return;
      const Result<DetectionSet> set = DetectionsFromMessage(*message, event.channel);
      if (set && !set->detections.empty()) with_detections_.insert(set->utime);
    }
  }

  [[nodiscard]] const std::string& channel() const { return channel_; }
  [[nodiscard]] const std::optional<CameraModel>& camera() const { return camera_; }
  [[nodiscard]] bool has_images() const { return !all_.empty(); }
  // By time of arrival.
  [[nodiscard]] const std::vector<int64_t>& images() const { return has_poses_ ? at_rest_ : all_; }
  // From 1.
  [[nodiscard]] int FirstWithDetections() const {
    const auto found = std::ranges::find_if(
        images(), [this](int64_t utime) { return with_detections_.contains(utime); });
    return found == images().end() ? 1 : static_cast<int>(found - images().begin()) + 1;
  }

 private:
  // Whether the camera rested is known only when poses of some time after the image are there.
  void OnPose(const rigid_transform_t& message) {
    const Result<Pose> pose = PoseFromMessage(message);
    if (!pose) return;
    has_poses_ = true;
    if (poses_.Add(message.utime, *pose)) pending_.clear();
    const std::optional<int64_t> newest = poses_.Newest();
    if (!newest) return;
    std::erase_if(pending_, [&](int64_t utime) {
      if (*newest < utime + window_) return false;
      if (poses_.RestsAt(utime, window_)) at_rest_.push_back(utime);
      return true;
    });
  }

  std::string channel_;
  int64_t window_;  // us
  std::optional<CameraModel> camera_;
  PoseBuffer poses_;
  bool has_poses_ = false;
  std::vector<int64_t> all_, pending_, at_rest_;  // us
  std::set<int64_t> with_detections_;             // us
};

Result<DepthImage> ReadImage(const std::filesystem::path& log,
                             const std::string& channel,
                             int64_t utime) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log);
  if (!reader) return reader.error();
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (event->channel != channel) continue;
    const auto message = DecodeChecked<images_t>(event->data);
    if (!message || message->utime != utime) continue;
    Result<DepthFrame> frame = DepthFrameFromMessage(*message);
    if (!frame) {
      return Error{
          frame.error().code,
          Format("log %s, %s: %s", log.c_str(), channel.c_str(), frame.error().message.c_str())};
    }
    return std::move(frame).value().image;
  }
  return Error{ErrorCode::kNotFound,
               Format("log %s changed while it was read, expected a finished one", log.c_str())};
}

Result<void> CheckIndex(const ImageIndex& index, const std::filesystem::path& log, int number) {
  const char* channel = index.channel().c_str();
  if (!index.has_images()) {
    return Error{ErrorCode::kNotFound,
                 Format("log %s has no images on %s, expected depth images of the camera",
                        log.c_str(),
                        channel)};
  }
  if (!index.camera()) {
    return Error{ErrorCode::kNotFound,
                 Format("log %s has no calibration on %s_INFO, expected one of the camera",
                        log.c_str(),
                        channel)};
  }
  if (index.images().empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("log %s has no image that was taken at rest by %s_TO_WORLD, expected one "
                        "that an estimator would use",
                        log.c_str(),
                        channel)};
  }
  if (number < 1 || number > static_cast<int>(index.images().size())) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--image %d, expected 1 to %zu, the images in %s that were taken at rest",
                        number,
                        index.images().size(),
                        log.c_str())};
  }
  return {};
}

}  // namespace

Result<StageImage> ReadStageImage(const std::filesystem::path& log,
                                  const std::string& camera,
                                  std::optional<int> number,
                                  double rest_window_s) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log);
  if (!reader) return reader.error();
  ImageIndex index(camera, rest_window_s);
  while (const std::optional<LogEvent> event = (*reader)->Next()) index.Read(*event);
  StageImage image;
  image.number = number.value_or(index.FirstWithDetections());
  if (Result<void> found = CheckIndex(index, log, image.number); !found) return found.error();
  image.count = static_cast<int>(index.images().size());
  image.utime = index.images()[static_cast<size_t>(image.number - 1)];
  image.camera = *index.camera();
  Result<DepthImage> depth = ReadImage(log, index.channel(), image.utime);
  if (!depth) return depth.error();
  image.depth = std::move(depth).value();
  if (image.depth.width != image.camera.width || image.depth.height != image.camera.height) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s has %d x %d px, expected the %d x %d px of %s_INFO",
                        index.channel().c_str(),
                        image.depth.width,
                        image.depth.height,
                        image.camera.width,
                        image.camera.height,
                        index.channel().c_str())};
  }
  return image;
}

}  // namespace vantage
