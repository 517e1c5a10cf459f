// What ViewerState makes of a camera's poses and images.

#include <algorithm>
#include <cmath>
#include <utility>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "tools/viewer/image_color.h"
#include "tools/viewer/viewer_state.h"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kRestWindow = 150'000;         // us, before and after an image
constexpr size_t kMaxWaiting = 8;                // images
constexpr float kPathStep = 0.004F;              // m
constexpr double kNewPlace = 0.02;               // m, that a camera moves between two clouds
constexpr double kNewDirection = 3.0 * kDegree;  // or turns

bool IsNearby(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm() < kNewPlace &&
         GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) <
             kNewDirection;
}

}  // namespace

void ViewerState::OnPose(const std::string& name, std::span<const std::byte> bytes) {
  const Result<rigid_transform_t> message = DecodeChecked<rigid_transform_t>(bytes);
  const Result<Pose> pose = message ? PoseFromMessage(*message) : Result<Pose>(message.error());
  if (!pose) {
    ++num_refused_;
    return;
  }
  ++num_used_;
  ShownCamera* camera = CameraNamed(name);
  if (camera == nullptr) return;
  CameraInput& input = inputs_[name];
  if (input.poses.Add(message->utime, *pose)) {  // The clock was set, or a log began again.
    input.waiting.clear();
    input.last_cloud.reset();
    camera->path.clear();
    cloud_.Clear();
  }
  camera->T_world_camera = *pose;
  const Eigen::Vector3f place = pose->translation().cast<float>();
  if (camera->path.empty() || (camera->path.back() - place).norm() > kPathStep) {
    camera->path.push_back(place);
  }
  if (camera->path.size() >= kMaxPath) {  // Every second one goes.
    for (size_t i = 0; 2 * i < camera->path.size(); ++i) camera->path[i] = camera->path[2 * i];
    camera->path.resize((camera->path.size() + 1) / 2);
  }
  AddResting(name);
}

void ViewerState::OnImages(const std::string& name, std::span<const std::byte> bytes) {
  if (name.empty()) return;
  Result<images_t> message = DecodeChecked<images_t>(bytes);
  if (!message) {
    ++num_refused_;
    return;
  }
  ++num_used_;
  if (CameraNamed(name) == nullptr) return;
  CameraInput& input = inputs_[name];
  input.waiting.push_back(std::make_shared<const images_t>(std::move(message).value()));
  if (input.waiting.size() > kMaxWaiting) input.waiting.pop_front();
}

// An image is judged once the poses go on long enough after it.
void ViewerState::AddResting(const std::string& name) {
  CameraInput& input = inputs_[name];
  const ShownCamera& camera = cameras_[name];
  while (!input.waiting.empty()) {
    const images_t& images = *input.waiting.front();
    const std::optional<int64_t> newest = input.poses.Newest();
    if (!newest || *newest < images.utime + kRestWindow) return;
    const std::optional<Pose> pose = input.poses.At(images.utime);
    const bool is_new = pose && (!input.last_cloud || !IsNearby(*pose, *input.last_cloud));
    if (is_new && camera.model && input.poses.RestsAt(images.utime, kRestWindow)) {
      const Result<DepthFrame> frame = DepthFrameFromMessage(images);
      if (frame) {
        cloud_.Add(frame->image, *camera.model, *pose, ColorOf(images, frame->image));
        input.last_cloud = *pose;
      } else {
        ++num_refused_;
      }
    }
    input.waiting.pop_front();
  }
}

}  // namespace vantage
