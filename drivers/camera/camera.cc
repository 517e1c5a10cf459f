#include "drivers/camera/camera.h"

#include <algorithm>
#include <utility>

#include "common/format.h"
#include "drivers/camera/frame_conversion.h"

namespace vantage {
namespace {

constexpr int kReopenAfter = 3;               // stall timeouts
constexpr int64_t kFpsInterval = 1'000'000;   // us
constexpr int64_t kLongestPause = 2'000'000;  // us, of a recording

int64_t Microseconds(std::chrono::milliseconds duration) {
  return std::chrono::microseconds(duration).count();
}

bool IsCalled(const DeviceListing& device, const DeviceSelector& selector) {
  if (selector.kind == DeviceSelector::Kind::kUri) return device.uri == selector.value;
  return std::ranges::find(device.aliases, selector.value) != device.aliases.end();
}

}  // namespace

Result<std::unique_ptr<Camera>> Camera::Create(const Options& options,
                                               std::unique_ptr<CameraDeviceApi> api) {
  const bool recording = options.device.kind == DeviceSelector::Kind::kRecording;
  if (recording) {
    if (Result<void> there = CheckRecording(options.device.value); !there) return there.error();
  }
  std::unique_ptr<Camera> camera(new Camera(options, std::move(api)));
  if (recording) {
    if (Result<void> open = camera->TryOpen(options.device.value); !open) return open.error();
  }
  return camera;
}

Camera::Camera(const Options& options, std::unique_ptr<CameraDeviceApi> api)
    : options_(options), api_(std::move(api)) {
  if (options_.device.kind == DeviceSelector::Kind::kSerial) wanted_serial_ = options_.device.value;
}

std::optional<CameraFrame> Camera::Grab(std::chrono::milliseconds timeout) {
  if (device_ != nullptr) return ReadFrame(timeout);
  if (finished_) {
    api_->Sleep(timeout);
  } else {
    Search(timeout);
  }
  return std::nullopt;
}

void Camera::Restart() {
  finished_ = false;
  next_attempt_us_ = 0;
  known_serials_.clear();
  Close(CameraState::kSearching, "restarted on command");
}

Result<void> Camera::SetExposure(int exposure_us) {
  if (device_ == nullptr) return Error{ErrorCode::kUnavailable, "exposure not set: no device yet"};
  return device_->SetExposure(exposure_us);
}

Result<void> Camera::SetGain(int gain) {
  if (device_ == nullptr) return Error{ErrorCode::kUnavailable, "gain not set: no device yet"};
  return device_->SetGain(gain);
}

Result<void> Camera::SetControl(const std::string& name, int64_t value) {
  if (device_ == nullptr) {
    return Error{ErrorCode::kUnavailable, "control " + name + " not set: no device yet"};
  }
  return device_->SetControl(name, value);
}

void Camera::SetState(CameraState state, const std::string& message) {
  const bool changed = state != status_.state;
  status_.state = state;
  status_.message = message;
  if (changed && options_.on_change) options_.on_change(status_);
}

// Searching and opening.

void Camera::Search(std::chrono::milliseconds timeout) {
  const int64_t wait_us = next_attempt_us_ - api_->MonotonicUs();
  if (wait_us > 0) {
    const auto wait = std::min(timeout, std::chrono::milliseconds((wait_us + 999) / 1000));
    if (!api_->WaitForDevice(wait)) return;
  }
  std::vector<DeviceListing> devices;
  if (options_.device.kind != DeviceSelector::Kind::kRecording) devices = api_->List();
  std::string refusal;
  for (const std::string& uri : Candidates(devices)) {
    const Result<void> opened = TryOpen(uri);
    if (opened) return;
    // A device with another serial is no failure, and is remembered.
    if (opened.error().code != ErrorCode::kNotFound) refusal = opened.error().message;
  }
  SetState(CameraState::kSearching, refusal.empty() ? NoDeviceMessage(devices) : refusal);
  next_attempt_us_ = api_->MonotonicUs() + Microseconds(refusal.empty() ? options_.search_interval
                                                                        : options_.retry_interval);
}

std::vector<std::string> Camera::Candidates(const std::vector<DeviceListing>& devices) {
  std::erase_if(known_serials_, [&devices](const auto& known) {
    return std::ranges::find(devices, known.first, &DeviceListing::uri) == devices.end();
  });
  for (const DeviceListing& device : devices) {
    if (!device.serial.empty()) known_serials_[device.uri] = device.serial;
  }
  const DeviceSelector& selector = options_.device;
  if (selector.kind == DeviceSelector::Kind::kRecording) return {selector.value};
  std::vector<std::string> candidates;
  if (!wanted_serial_.empty()) {
    for (const DeviceListing& device : devices) {
      const auto known = known_serials_.find(device.uri);
      if (known == known_serials_.end() || known->second == wanted_serial_) {
        candidates.push_back(device.uri);
      }
    }
  } else if (selector.kind == DeviceSelector::Kind::kIndex) {
    const size_t index = static_cast<size_t>(selector.index);
    if (index < devices.size()) candidates.push_back(devices[index].uri);
  } else {
    for (const DeviceListing& device : devices) {
      if (IsCalled(device, selector)) candidates.push_back(device.uri);
    }
  }
  return candidates;
}

Result<void> Camera::TryOpen(const std::string& uri) {
  SetState(CameraState::kOpening, "opening " + uri);
  Result<std::unique_ptr<CameraDevice>> device = api_->Open(uri);
  if (!device) {
    // Whatever the reason, it is not a matter of the serial.
    return Error{ErrorCode::kUnavailable, device.error().message};
  }
  std::string serial = (*device)->serial();
  const bool has_serial = !serial.empty();
  if (!has_serial) serial = uri;
  if (options_.device.kind != DeviceSelector::Kind::kRecording) {
    known_serials_[uri] = serial;
    if (!wanted_serial_.empty() && serial != wanted_serial_) {
      return Error{ErrorCode::kNotFound, "another serial"};
    }
  }
  const Result<StreamDetails> details = (*device)->Start(options_.stream);
  if (!details) return Error{ErrorCode::kUnavailable, details.error().message};
  if (Result<void> fits = Adopt(uri, *details); !fits) {
    return Error{ErrorCode::kUnavailable, fits.error().message};
  }
  device_ = std::move(device).value();
  status_.serial = serial;
  if (has_serial && options_.device.kind != DeviceSelector::Kind::kRecording) {
    wanted_serial_ = serial;
  }
  if (std::exchange(was_open_, true)) ++status_.num_reconnects;
  SetState(CameraState::kStreaming, details_.note);
  return {};
}

Result<void> Camera::Adopt(const std::string& uri, const StreamDetails& details) {
  Result<Rectification> rectification =
      Rectification::Create(details, options_.stream, options_.calibration);
  if (!rectification) {
    return Error{ErrorCode::kUnavailable, "device " + uri + ": " + rectification.error().message};
  }
  rectification_ = std::move(rectification).value();
  details_ = details;
  const std::string& lacking = rectification_->note();
  details_.note += (details.note.empty() || lacking.empty() ? "" : "; ") + lacking;
  clock_.Reset(details.clock_modulus_us);
  first_device_us_.reset();
  last_frame_us_ = fps_since_us_ = api_->MonotonicUs();
  fps_frames_ = 0;
  last_index_ = -1;
  return {};
}

std::string Camera::NoDeviceMessage(const std::vector<DeviceListing>& devices) const {
  std::string found;
  for (const DeviceListing& device : devices) {
    found += (found.empty() ? "" : ", ") + device.uri;
    const auto known = known_serials_.find(device.uri);
    if (known != known_serials_.end()) found += " (serial " + known->second + ")";
  }
  if (found.empty()) found = "none";
  const std::string wanted =
      wanted_serial_.empty() ? options_.device.Text() : "serial:" + wanted_serial_;
  return Format("no %s device matches %s (found: %s); waiting for one; %s",
                api_->name().c_str(),
                wanted.c_str(),
                found.c_str(),
                api_->search_hint().c_str());
}

void Camera::Close(CameraState state, const std::string& message) {
  device_.reset();
  status_.fps = 0.0;
  SetState(state, message);
}

// Reading.

std::optional<CameraFrame> Camera::ReadFrame(std::chrono::milliseconds timeout) {
  RawFrame raw;
  const CameraDevice::ReadResult result = device_->Read(timeout, &raw);
  const int64_t now_us = api_->MonotonicUs();
  const int64_t arrival_utime = api_->WallUs();
  switch (result) {
    case CameraDevice::ReadResult::kFrame:
    case CameraDevice::ReadResult::kBad:
      CountFrame(now_us);
      CountMissed(raw.index);
      last_frame_us_ = now_us;
      if (result == CameraDevice::ReadResult::kFrame) return Convert(raw, arrival_utime);
      ReportFault(raw.fault);
      return std::nullopt;
    case CameraDevice::ReadResult::kTimeout:
      NoFrame();
      return std::nullopt;
    case CameraDevice::ReadResult::kGone:
      Close(CameraState::kLost, Name() + " was unplugged; searching for it");
      // A device that is gone leaves the list a little later.
      next_attempt_us_ = now_us + Microseconds(options_.search_interval);
      return std::nullopt;
    case CameraDevice::ReadResult::kEnd:
      EndRecording();
      return std::nullopt;
  }
  return std::nullopt;
}

void Camera::EndRecording() {
  finished_ = true;
  Close(CameraState::kLost,
        Format("the recording %s is over; the command \"restart\" plays it again",
               options_.device.value.c_str()));
}

void Camera::NoFrame() {
  const int64_t now_us = api_->MonotonicUs();
  if (now_us - fps_since_us_ >= kFpsInterval) status_.fps = 0.0;
  const int64_t silence_us = now_us - last_frame_us_;
  if (silence_us < Microseconds(options_.stall_timeout)) return;
  const std::string message = Format(
      "%s gives no frame for %.1f s", Name().c_str(), 1e-6 * static_cast<double>(silence_us));
  SetState(CameraState::kStalled, message);
  if (silence_us < kReopenAfter * Microseconds(options_.stall_timeout)) return;
  if (details_.is_recording) {
    EndRecording();
  } else {
    Close(CameraState::kSearching, message + "; opening it anew");
  }
}

void Camera::CountFrame(int64_t now_us) {
  ++status_.num_captured;
  ++fps_frames_;
  const int64_t elapsed_us = now_us - fps_since_us_;
  if (elapsed_us < kFpsInterval) return;
  status_.fps = 1e6 * static_cast<double>(fps_frames_) / static_cast<double>(elapsed_us);
  fps_since_us_ = now_us;
  fps_frames_ = 0;
}

// A device that counts anew, or plays a recording again, has lost nothing.
void Camera::CountMissed(int64_t index) {
  if (index < 0) return;
  if (last_index_ >= 0 && index > last_index_) status_.num_missed += index - last_index_ - 1;
  last_index_ = index;
}

void Camera::ReportFault(const std::string& fault) {
  ++status_.num_bad;
  SetState(CameraState::kStreaming, Name() + ": " + fault);
}

std::optional<CameraFrame> Camera::Convert(const RawFrame& raw, int64_t arrival_utime) {
  if (const std::string fault = FrameFault(raw, details_); !fault.empty()) {
    ReportFault(fault);
    return std::nullopt;
  }
  CameraFrame frame;
  if (raw.depth) frame.depth_mm = DepthMillimetres(*raw.depth, details_);
  frame.device_time_us = raw.depth ? raw.depth->device_time_us : raw.color->device_time_us;
  frame.serial = status_.serial;
  frame.utime = details_.is_recording ? RecordingTime(frame.device_time_us)
                                      : clock_.Update(frame.device_time_us, arrival_utime);
  AddColor(raw, &frame);
  if (const std::string fault = rectification_->Apply(&frame); !fault.empty()) {
    ReportFault(fault);
    return std::nullopt;
  }
  const char* separator = details_.note.empty() || raw.fault.empty() ? "" : "; ";
  SetState(CameraState::kStreaming, details_.note + separator + raw.fault);
  const double offset_us = details_.is_recording
                               ? static_cast<double>(frame.utime - frame.device_time_us)
                               : clock_.offset_us();
  status_.clock_offset_s = 1e-6 * offset_us;
  status_.clock_skew_ppm = details_.is_recording ? 0.0 : clock_.skew_ppm();
  status_.num_clock_steps = clock_.num_steps();
  return frame;
}

void Camera::AddColor(const RawFrame& raw, CameraFrame* frame) {
  if (!raw.color) {
    if (details_.has_color) ++status_.num_unpaired;
    return;
  }
  frame->color = ColorImageOf(*raw.color, details_);
  const int64_t delay_us = raw.color->device_time_us - frame->device_time_us;
  frame->color->utime = frame->utime + delay_us;
  status_.color_delay_s = 1e-6 * static_cast<double>(delay_us);
}

// A recording's frames keep the distances of its stamps, from the time when it began to play.
int64_t Camera::RecordingTime(int64_t device_us) {
  const int64_t elapsed_us = device_us - first_device_us_.value_or(device_us);
  if (!first_device_us_) {
    first_device_us_ = device_us;
    first_utime_ = api_->WallUs();
    first_monotonic_us_ = api_->MonotonicUs();
  }
  const int64_t wait_us = first_monotonic_us_ + elapsed_us - api_->MonotonicUs();
  if (wait_us > 0) api_->Sleep(std::chrono::microseconds(std::min(wait_us, kLongestPause)));
  return first_utime_ + elapsed_us;
}

std::string Camera::Name() const { return "device " + status_.serial; }

}  // namespace vantage
