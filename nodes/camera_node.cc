#include "nodes/camera_node.h"

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "common/camera_intrinsics.h"
#include "common/format.h"
#include "drivers/camera/camera.h"
#include "drivers/clock/rate_limiter.h"
#include "drivers/openni2/openni2_api.h"
#include "vantage/camera_command_v2_t.hpp"
#include "vantage/camera_info_t.hpp"
#include "vantage/camera_status_v2_t.hpp"
#include "vantage/images_t.hpp"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kGrabTimeout{100};
constexpr std::chrono::seconds kRepeatInterval{1};  // of _INFO and _STATUS
constexpr std::chrono::seconds kNoteDuration{10};   // for which _STATUS says what went wrong
constexpr double kHighestRate = 1000.0;             // Hz
constexpr size_t kMostControls = 256;

double SecondsSince(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

// What CAMERA_<NAME>_INFO depends on.
struct InfoContent {
  CameraIntrinsics intrinsics;
  std::string serial;
  bool registered = false;
  bool operator==(const InfoContent&) const = default;
};

// What commands asked for and the capture thread has yet to do.
struct Commands {
  std::optional<int> exposure_us;
  std::optional<int> gain;
  std::map<std::string, int64_t> controls;
  std::optional<double> rate_hz;
  bool restart = false;
};

class CameraNode : public Node {
 public:
  CameraNode(Bus& bus, const CameraConfig& config, const std::string& process_name)
      : bus_(bus),
        config_(config),
        process_name_(process_name),
        channel_("CAMERA_" + config.name),
        limiter_(config.rate_hz) {
    settings_.controls = config.controls;
  }

  Result<void> Start(std::unique_ptr<CameraDeviceApi> api);
  void Poll() override;
  [[nodiscard]] milliseconds poll_interval() const override { return milliseconds(20); }

 private:
  void HandleCommand(const camera_command_v2_t& command);
  void Note(const std::string& note);

  // The capture thread.
  void Capture(const std::stop_token& stop);
  void Obey();
  void Tell(const CameraStatus& status);
  void Offer(CameraFrame frame);

  // The publishing thread.
  void PublishFrames(const std::stop_token& stop);
  void PublishFrame(const CameraFrame& frame);
  void AppendColor(const CameraFrame& frame, images_t* message) const;

  // The bus's thread.
  void PublishStatus(const CameraStatus& status);
  void PublishInfo(const InfoContent& info);

  Bus& bus_;
  const CameraConfig config_;
  const std::string process_name_;
  const std::string channel_;

  std::unique_ptr<Camera> camera_;    // Of the capture thread once that runs.
  RateLimiter limiter_;               // Of the capture thread.
  Commands settings_;                 // Of the capture thread: in force, for a device anew.
  int64_t settings_reconnects_ = -1;  // Of the capture thread; -1: no device had them yet.
  bool told_absent_ = false;          // Of the capture thread.

  int64_t image_seq_ = 0;  // Of the publishing thread.

  int64_t status_seq_ = 0;  // Of the bus's thread, as what follows.
  int64_t info_seq_ = 0;
  std::optional<InfoContent> published_info_;
  std::optional<steady_clock::time_point> last_status_;
  std::optional<steady_clock::time_point> last_info_;

  std::mutex mutex_;  // Guards what follows.
  std::condition_variable_any frame_ready_;
  std::optional<CameraFrame> newest_;  // Waits to be published.
  CameraStatus status_;
  std::vector<CameraStatus> changes_;  // Of state, yet to be published.
  std::optional<InfoContent> info_;
  Commands commands_;
  std::string note_;  // What a command asked for in vain, or why an image was not sent.
  steady_clock::time_point note_until_;
  int64_t num_published_ = 0;
  int64_t num_left_out_ = 0;  // Good frames that the rate limit or a newer one displaced.
  double latency_s_ = 0.0;

  std::jthread capture_thread_;  // Last, so that they end first.
  std::jthread publish_thread_;
};

Result<void> CameraNode::Start(std::unique_ptr<CameraDeviceApi> api) {
  Camera::Options options;
  options.device = config_.device;
  options.stream = config_.stream;
  options.calibration = config_.calibration;
  options.stall_timeout = milliseconds(std::llround(1e3 * config_.stall_timeout_s));
  options.on_change = [this](const CameraStatus& status) {
    Tell(status);
    const std::lock_guard lock(mutex_);
    changes_.push_back(status);
  };
  Result<std::unique_ptr<Camera>> camera = Camera::Create(options, std::move(api));
  if (!camera) return camera.error();
  camera_ = std::move(camera).value();

  SubscribeOptions all;
  all.keep = SubscribeOptions::Keep::kAll;
  Result<void> subscribed = bus_.Subscribe<camera_command_v2_t>(
      channel_ + "_COMMAND", all, [this](const Envelope&, const camera_command_v2_t& command) {
        HandleCommand(command);
      });
  if (!subscribed) return subscribed;
  capture_thread_ = std::jthread([this](const std::stop_token& stop) { Capture(stop); });
  publish_thread_ = std::jthread([this](const std::stop_token& stop) { PublishFrames(stop); });
  return {};
}

void CameraNode::HandleCommand(const camera_command_v2_t& command) {
  const std::lock_guard lock(mutex_);
  if (command.exposure_us >= 0) commands_.exposure_us = command.exposure_us;
  if (command.gain >= 0) commands_.gain = command.gain;
  for (size_t i = 0; i < command.control_names.size(); ++i) {
    if (commands_.controls.size() >= kMostControls) break;
    commands_.controls[command.control_names[i]] = command.control_values[i];
  }
  if (!std::isfinite(command.rate) || command.rate > kHighestRate) {
    Note(
        Format("command ignored: rate = %g Hz, expected at most %g, 0 to leave it or a "
               "negative number for every frame",
               command.rate,
               kHighestRate));
  } else if (command.rate != 0.0) {
    commands_.rate_hz = command.rate;
  }
  commands_.restart = commands_.restart || command.restart;
}

// With mutex_ locked.
void CameraNode::Note(const std::string& note) {
  note_ = note;
  note_until_ = steady_clock::now() + kNoteDuration;
}

void CameraNode::Capture(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Obey();
    std::optional<CameraFrame> frame = camera_->Grab(kGrabTimeout);
    const CameraStatus& status = camera_->status();
    if (status.state == CameraState::kSearching && !status.message.empty()) Tell(status);
    {
      const std::lock_guard lock(mutex_);
      if (status.num_clock_steps > status_.num_clock_steps) {
        Note(Format("the host's or the device's clock was set or started anew (%d times so far)",
                    status.num_clock_steps));
      }
      status_ = status;
    }
    if (frame) Offer(*std::move(frame));
  }
}

void CameraNode::Obey() {
  Commands commands;
  {
    const std::lock_guard lock(mutex_);
    std::swap(commands, commands_);
  }
  if (commands.rate_hz) limiter_.SetRate(*commands.rate_hz);
  if (commands.restart) camera_->Restart();
  // A device that came knows no settings yet, one that came back has forgotten them.
  const CameraStatus& status = camera_->status();
  const bool streaming = status.state == CameraState::kStreaming;
  const bool anew = streaming && status.num_reconnects != settings_reconnects_;
  if (anew) settings_reconnects_ = status.num_reconnects;
  std::string note;
  const auto apply = [&](std::optional<int>* in_force, const std::optional<int>& asked, auto set) {
    if (!asked && !(anew && *in_force)) return;
    if (asked) *in_force = asked;
    const Result<void> done = (camera_.get()->*set)(**in_force);
    if (!done) note += (note.empty() ? "" : "; ") + done.error().message;
  };
  apply(&settings_.exposure_us, commands.exposure_us, &Camera::SetExposure);
  apply(&settings_.gain, commands.gain, &Camera::SetGain);
  for (const auto& [name, value] : commands.controls) settings_.controls[name] = value;
  // In the order of their names, in which V4L2's "auto_exposure" comes before the exposure.
  for (const auto& [name, value] : anew ? settings_.controls : commands.controls) {
    const Result<void> done = camera_->SetControl(name, value);
    if (!done) note += (note.empty() ? "" : "; ") + done.error().message;
  }
  if (note.empty()) return;
  const std::lock_guard lock(mutex_);
  Note(note);
}

// On the console, for who starts it by hand: what is missing once, then that it came.
void CameraNode::Tell(const CameraStatus& status) {
  switch (status.state) {
    case CameraState::kOpening:
      return;
    case CameraState::kSearching:
      if (status.message.empty() || std::exchange(told_absent_, true)) return;
      break;
    case CameraState::kStreaming:
      told_absent_ = false;
      std::fprintf(stderr,
                   "%s: streaming from device %s%s%s\n",
                   process_name_.c_str(),
                   status.serial.c_str(),
                   status.message.empty() ? "" : "; ",
                   status.message.c_str());
      return;
    case CameraState::kStalled:
    case CameraState::kLost:
      break;
  }
  std::fprintf(stderr, "%s: %s\n", process_name_.c_str(), status.message.c_str());
}

void CameraNode::Offer(CameraFrame frame) {
  const bool due = limiter_.Accept(frame.utime);
  const std::lock_guard lock(mutex_);
  if (frame.model)
    info_ = InfoContent{{*frame.model, frame.distortion}, frame.serial, frame.registered};
  if (!due) {
    ++num_left_out_;
    return;
  }
  if (newest_) ++num_left_out_;
  newest_ = std::move(frame);
  frame_ready_.notify_one();
}

void CameraNode::PublishFrames(const std::stop_token& stop) {
  while (true) {
    std::optional<CameraFrame> frame;
    {
      std::unique_lock lock(mutex_);
      if (!frame_ready_.wait(lock, stop, [this] { return newest_.has_value(); })) return;
      frame = std::exchange(newest_, std::nullopt);
    }
    PublishFrame(*frame);
  }
}

void CameraNode::PublishFrame(const CameraFrame& frame) {
  const steady_clock::time_point start = steady_clock::now();
  images_t message{};
  message.utime = frame.utime;
  if (!frame.depth_mm.empty()) {
    message = DepthToMessage(frame.width,
                             frame.height,
                             frame.depth_mm,
                             frame.utime,
                             image_seq_,
                             frame.serial,
                             config_.compression);
    bus_.RecordStage("compress", SecondsSince(start));
  }
  if (frame.color) AppendColor(frame, &message);
  const Result<void> published = bus_.Publish(channel_, message);
  const double latency_s = 1e-6 * static_cast<double>(bus_.NowUtime() - frame.utime);
  bus_.RecordStage("capture_to_publish", latency_s);
  const std::lock_guard lock(mutex_);
  if (!published) {
    Note(published.error().message);
    ++num_left_out_;
    return;
  }
  ++image_seq_;
  ++num_published_;
  latency_s_ = latency_s;
}

void CameraNode::AppendColor(const CameraFrame& frame, images_t* message) const {
  const ColorImage& color = *frame.color;
  image_t image{};
  image.utime = color.utime;
  image.width = color.width;
  image.height = color.height;
  switch (color.layout) {
    case PixelLayout::kRgb8:
      image.pixelformat = image_t::PIXEL_FORMAT_RGB;
      image.row_stride = 3 * color.width;
      break;
    case PixelLayout::kGray8:
      image.pixelformat = image_t::PIXEL_FORMAT_GRAY;
      image.row_stride = color.width;
      break;
    case PixelLayout::kJpeg:
      image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
      break;
    case PixelLayout::kDepth16:
      VANTAGE_CHECK(false, "depth is no color image");
  }
  image.data = color.data;
  if (frame.depth_mm.empty()) AppendIdentity(image_seq_, frame.serial, &image);
  AppendImage(images_t::LEFT, std::move(image), message);
}

void CameraNode::Poll() {
  std::vector<CameraStatus> changes;
  CameraStatus status;
  std::optional<InfoContent> info;
  {
    const std::lock_guard lock(mutex_);
    std::swap(changes, changes_);
    status = status_;
    info = info_;
  }
  const steady_clock::time_point now = steady_clock::now();
  for (const CameraStatus& change : changes) PublishStatus(change);
  if (!changes.empty()) last_status_ = now;
  if (!last_status_ || now - *last_status_ >= kRepeatInterval) {
    last_status_ = now;
    PublishStatus(status);
  }
  if (info && (info != published_info_ || now - *last_info_ >= kRepeatInterval)) {
    last_info_ = now;
    published_info_ = info;
    PublishInfo(*info);
  }
}

void CameraNode::PublishStatus(const CameraStatus& status) {
  camera_status_v2_t message{};
  message.utime = bus_.NowUtime();
  message.seq = status_seq_++;
  message.name = config_.name;
  message.serial = status.serial;
  message.state = static_cast<int8_t>(status.state);
  message.message = status.message;
  message.num_captured = status.num_captured;
  message.num_bad = status.num_bad;
  message.num_missed = status.num_missed;
  message.num_unpaired = status.num_unpaired;
  message.num_reconnects = status.num_reconnects;
  message.fps = status.fps;
  message.color_delay = status.color_delay_s;
  message.clock_offset = status.clock_offset_s;
  message.clock_skew = status.clock_skew_ppm;
  {
    const std::lock_guard lock(mutex_);
    if (steady_clock::now() < note_until_) {
      message.message += (message.message.empty() ? "" : "; ") + note_;
    }
    message.num_published = num_published_;
    message.num_dropped = num_left_out_ + status.num_bad;
    message.latency = latency_s_;
  }
  bus_.SetState(status.message.empty() ? "ok" : status.message);
  // What can't be sent now is sent again in a second.
  (void)bus_.Publish(channel_ + "_STATUS", message);
}

void CameraNode::PublishInfo(const InfoContent& info) {
  CameraIdentity identity;
  identity.name = config_.name;
  identity.serial = info.serial;
  identity.frame = channel_;
  identity.registered = info.registered;
  identity.calibration_id = config_.calibration ? config_.calibration->id : "field of view";
  const camera_info_t message = CameraToMessage(
      info.intrinsics.camera, identity, bus_.NowUtime(), info_seq_++, info.intrinsics.distortion);
  (void)bus_.Publish(channel_ + "_INFO", message);
}

}  // namespace

Result<std::unique_ptr<Node>> MakeCameraNode(Bus& bus,
                                             const CameraConfig& config,
                                             const std::string& process_name,
                                             std::unique_ptr<CameraDeviceApi> api) {
  auto node = std::make_unique<CameraNode>(bus, config, process_name);
  if (Result<void> started = node->Start(std::move(api)); !started) return started.error();
  return std::unique_ptr<Node>(std::move(node));
}

}  // namespace vantage
