#include "tests/drivers/v4l2_live/live_camera.h"

#include <algorithm>
#include <stdexcept>

#include "common/format.h"
#include "drivers/v4l2/v4l2_api.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience(30);

}  // namespace

std::string SmallFormat(const std::string& fourcc) {
  return Format("format %s %dx%d 30\n", fourcc.c_str(), LiveCamera::kWidth, LiveCamera::kHeight);
}

std::string DeviceZero(const std::string& lines) {
  return "device 0\nserial CAM0\nspeed 10\n" + lines + "\n";
}

LiveCamera::LiveCamera(const Settings& settings) {
  Camera::Options options;
  const Result<DeviceSelector> device = DeviceSelector::Parse(settings.device);
  if (!device) throw std::runtime_error(device.error().message);
  options.device = *device;
  options.stream = settings.stream;
  options.stall_timeout = milliseconds(300);
  options.search_interval = milliseconds(20);
  options.retry_interval = milliseconds(20);
  options.on_change = [this](const CameraStatus& status) { states_.push_back(status.state); };
  Result<std::unique_ptr<Camera>> camera =
      Camera::Create(options, std::make_unique<V4l2Api>(settings.v4l2, *device));
  if (!camera) throw std::runtime_error(camera.error().message);
  camera_ = std::move(camera).value();
}

void LiveCamera::Grab() {
  std::optional<CameraFrame> frame = camera_->Grab(milliseconds(20));
  messages_.insert(status().message);
  if (!frame) return;
  ++num_frames_;
  frame_ = *std::move(frame);
  if (on_frame) on_frame(frame_);
}

bool LiveCamera::GrabUntil(const std::function<bool()>& condition) {
  const steady_clock::time_point give_up = steady_clock::now() + kPatience;
  while (!condition()) {
    if (steady_clock::now() > give_up) return false;
    Grab();
  }
  return true;
}

bool LiveCamera::GrabFrames(size_t count) {
  const size_t wanted = num_frames_ + count;
  return GrabUntil([&] { return num_frames_ >= wanted; });
}

bool LiveCamera::GrabUntilMessage(const std::string& text) {
  return GrabUntil([&] {
    return std::ranges::any_of(messages_, [&](const std::string& message) {
      return message.find(text) != std::string::npos;
    });
  });
}

bool LiveCamera::GrabUntilState(CameraState state) {
  return GrabUntil([&] { return status().state == state; });
}

bool LiveCamera::HasBeen(CameraState state) const {
  return std::ranges::find(states_, state) != states_.end();
}

std::string LiveCamera::Summary() const {
  std::string text = Format("state %d, captured %jd, bad %jd, missed %jd, reconnects %jd",
                            static_cast<int>(status().state),
                            intmax_t{status().num_captured},
                            intmax_t{status().num_bad},
                            intmax_t{status().num_missed},
                            intmax_t{status().num_reconnects});
  for (const std::string& message : messages_) text += "\n  " + message;
  return text;
}

}  // namespace vantage
