#include "tools/log/view_collector.h"

#include <utility>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "bus/wire.h"
#include "common/time_range.h"

namespace vantage {
namespace {

constexpr std::string_view kPrefix = "CAMERA_";
constexpr std::string_view kPoseSuffix = "_TO_WORLD";
constexpr std::string_view kInfoSuffix = "_INFO";

bool HasType(const LogEventView& event, int64_t fingerprint) {
  return event.data.size() >= sizeof(int64_t) && LoadBigEndian<int64_t>(event.data) == fingerprint;
}

std::string NameOf(std::string_view channel, std::string_view suffix) {
  channel.remove_prefix(kPrefix.size());
  channel.remove_suffix(suffix.size());
  return std::string(channel);
}

}  // namespace

Result<void> ViewCollector::Add(const LogEventView& event, bool wanted) {
  if (!event.channel.starts_with(kPrefix) || event.channel.size() == kPrefix.size()) return {};
  if (event.channel.ends_with(kPoseSuffix) && HasType(event, rigid_transform_t::getHash())) {
    Camera* camera = Find(NameOf(event.channel, kPoseSuffix));
    const Result<rigid_transform_t> message = DecodeChecked<rigid_transform_t>(event.data);
    const Result<Pose> pose = message ? PoseFromMessage(*message) : message.error();
    if (pose && camera != nullptr) camera->poses.Add(message->utime, *pose);
    num_malformed_ += pose ? 0 : 1;
  } else if (event.channel.ends_with(kInfoSuffix) && HasType(event, camera_info_t::getHash())) {
    Camera* camera = Find(NameOf(event.channel, kInfoSuffix));
    const Result<camera_info_t> message = DecodeChecked<camera_info_t>(event.data);
    const Result<CameraModel> model = message ? CameraFromMessage(*message) : message.error();
    num_malformed_ += model ? 0 : 1;
    if (camera != nullptr && model) {
      camera->model = *model;
      camera->registered = message->registered != 0;
    }
  } else if (wanted && HasType(event, images_t::getHash())) {
    Result<images_t> images = DecodeChecked<images_t>(event.data);
    if (!images || !IsPlausibleUtime(images->utime)) {
      ++num_malformed_;
      return {};
    }
    const std::string name = NameOf(event.channel, "");
    CameraView view;
    view.camera = name;
    view.utime = images->utime;
    view.images = std::move(*images);
    if (!view.images.images.empty()) view.seq = ImageSeq(view.images.images.front());
    if (const Camera* camera = Find(name); camera != nullptr) {
      view.model = camera->model;
      view.registered = camera->registered;
    }
    waiting_.push_back({std::move(view), event.utime, event.data.size()});
    waiting_bytes_ += event.data.size();
  }
  while (!waiting_.empty()) {
    const Waiting& first = waiting_.front();
    const Camera* camera = Find(first.view.camera);
    const std::optional<int64_t> newest = camera == nullptr ? std::nullopt : camera->poses.Newest();
    const bool is_ready = newest && *newest >= first.view.utime;
    const bool is_late = event.utime > first.event_utime + kPatience ||
                         event.utime < first.event_utime - kPatience || waiting_bytes_ > kMostBytes;
    if (!is_ready && !is_late) return {};
    if (Result<void> visited = VisitFirst(); !visited) return visited;
  }
  return {};
}

Result<void> ViewCollector::Finish() {
  while (!waiting_.empty()) {
    if (Result<void> visited = VisitFirst(); !visited) return visited;
  }
  return {};
}

ViewCollector::Camera* ViewCollector::Find(const std::string& name) {
  const auto found = cameras_.find(name);
  if (found != cameras_.end()) return &found->second;
  if (cameras_.size() >= kMostCameras) return nullptr;
  return &cameras_[name];
}

Result<void> ViewCollector::VisitFirst() {
  Waiting first = std::move(waiting_.front());
  waiting_.pop_front();
  waiting_bytes_ -= first.bytes;
  if (const Camera* camera = Find(first.view.camera); camera != nullptr) {
    first.view.T_world_camera = camera->poses.At(first.view.utime);
    // An image that is the first of its camera comes before its calibration.
    if (!first.view.model) {
      first.view.model = camera->model;
      first.view.registered = camera->registered;
    }
  }
  return visit_(first.view);
}

}  // namespace vantage
