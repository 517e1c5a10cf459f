#include "drivers/openni2/openni2_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/format.h"
#include "drivers/openni2/frame_conversion.h"

namespace vantage {
namespace {

constexpr int kReopenAfter = 3;               // stall timeouts
constexpr int64_t kFpsInterval = 1'000'000;   // us
constexpr int64_t kLongestPause = 2'000'000;  // us, of a recording

int64_t Microseconds(std::chrono::milliseconds duration) {
  return std::chrono::microseconds(duration).count();
}

bool IsFieldOfView(double angle) { return angle > 0.0 && angle < std::numbers::pi; }

}  // namespace

Result<std::unique_ptr<Openni2Camera>> Openni2Camera::Create(const Options& options,
                                                             std::unique_ptr<DepthDeviceApi> api) {
  const bool recording = options.device.kind == DeviceSelector::Kind::kRecording;
  if (recording) {
    if (Result<void> there = CheckRecording(options.device.value); !there) return there.error();
  }
  std::unique_ptr<Openni2Camera> camera(new Openni2Camera(options, std::move(api)));
  if (recording) {
    if (Result<void> open = camera->TryOpen(options.device.value); !open) return open.error();
  }
  return camera;
}

Openni2Camera::Openni2Camera(const Options& options, std::unique_ptr<DepthDeviceApi> api)
    : options_(options), api_(std::move(api)) {
  if (options_.device.kind == DeviceSelector::Kind::kSerial) wanted_serial_ = options_.device.value;
}

std::optional<CameraFrame> Openni2Camera::Grab(std::chrono::milliseconds timeout) {
  if (device_ != nullptr) return ReadFrame(timeout);
  if (finished_) {
    api_->Sleep(timeout);
  } else {
    Search(timeout);
  }
  return std::nullopt;
}

void Openni2Camera::Restart() {
  finished_ = false;
  next_attempt_us_ = 0;
  known_serials_.clear();
  Close(CameraState::kSearching, "restarted on command");
}

Result<void> Openni2Camera::SetExposure(int exposure_us) {
  if (device_ == nullptr) return Error{ErrorCode::kUnavailable, "exposure not set: no device yet"};
  return device_->SetExposure(exposure_us);
}

Result<void> Openni2Camera::SetGain(int gain) {
  if (device_ == nullptr) return Error{ErrorCode::kUnavailable, "gain not set: no device yet"};
  return device_->SetGain(gain);
}

void Openni2Camera::SetState(CameraState state, const std::string& message) {
  const bool changed = state != status_.state;
  status_.state = state;
  status_.message = message;
  if (changed && options_.on_change) options_.on_change(status_);
}

// Searching and opening.

void Openni2Camera::Search(std::chrono::milliseconds timeout) {
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

std::vector<std::string> Openni2Camera::Candidates(const std::vector<DeviceListing>& devices) {
  std::erase_if(known_serials_, [&devices](const auto& known) {
    return std::ranges::find(devices, known.first, &DeviceListing::uri) == devices.end();
  });
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
  } else if (std::ranges::find(devices, selector.value, &DeviceListing::uri) != devices.end()) {
    candidates.push_back(selector.value);
  }
  return candidates;
}

Result<void> Openni2Camera::TryOpen(const std::string& uri) {
  SetState(CameraState::kOpening, "opening " + uri);
  Result<std::unique_ptr<DepthDevice>> device = api_->Open(uri);
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

Result<void> Openni2Camera::Adopt(const std::string& uri, const StreamDetails& details) {
  const auto refuse = [&uri](const std::string& reason) {
    return Error{ErrorCode::kUnavailable, "device " + uri + ": " + reason};
  };
  if (options_.calibration) {
    model_ = *options_.calibration;
    if (model_.width != details.width || model_.height != details.height) {
      return refuse(Format("gives depth of %d x %d px, expected the %d x %d px of the calibration",
                           details.width,
                           details.height,
                           model_.width,
                           model_.height));
    }
  } else {
    if (!IsFieldOfView(details.horizontal_fov) || !IsFieldOfView(details.vertical_fov)) {
      return refuse(
          Format("reports a field of view of %g x %g rad, expected each between 0 and pi; "
                 "a calibration file can stand in for it",
                 details.horizontal_fov,
                 details.vertical_fov));
    }
    model_ = CameraFromFieldOfView(
        details.width, details.height, details.horizontal_fov, details.vertical_fov);
  }
  if (Result<void> valid = model_.Validate(); !valid) return refuse(valid.error().message);
  details_ = details;
  undistortion_.clear();
  if (options_.calibration && options_.distortion) {
    undistortion_ = UndistortionMap(model_, *options_.distortion);
  }
  clock_.Reset();
  first_device_us_.reset();
  last_frame_us_ = fps_since_us_ = api_->MonotonicUs();
  fps_frames_ = 0;
  return {};
}

std::string Openni2Camera::NoDeviceMessage(const std::vector<DeviceListing>& devices) const {
  std::string found;
  for (const DeviceListing& device : devices) {
    found += (found.empty() ? "" : ", ") + device.uri;
    const auto known = known_serials_.find(device.uri);
    if (known != known_serials_.end()) found += " (serial " + known->second + ")";
  }
  if (found.empty()) found = "none";
  const std::string wanted =
      wanted_serial_.empty() ? options_.device.Text() : "serial:" + wanted_serial_;
  return "no OpenNI2 device matches " + wanted + " (found: " + found +
         "); waiting for one; check the cable, `lsusb`, and udev rules";
}

void Openni2Camera::Close(CameraState state, const std::string& message) {
  device_.reset();
  status_.fps = 0.0;
  SetState(state, message);
}

// Reading.

std::optional<CameraFrame> Openni2Camera::ReadFrame(std::chrono::milliseconds timeout) {
  RawFrame raw;
  const DepthDevice::ReadResult result = device_->Read(timeout, &raw);
  const int64_t now_us = api_->MonotonicUs();
  const int64_t arrival_utime = api_->WallUs();
  switch (result) {
    case DepthDevice::ReadResult::kFrame: {
      CountFrame(now_us);
      last_frame_us_ = now_us;
      return Convert(raw, arrival_utime);
    }
    case DepthDevice::ReadResult::kTimeout:
      NoFrame();
      return std::nullopt;
    case DepthDevice::ReadResult::kGone:
      Close(CameraState::kLost, Name() + " was unplugged; searching for it");
      // A device that is gone leaves the list a little later.
      next_attempt_us_ = now_us + Microseconds(options_.search_interval);
      return std::nullopt;
    case DepthDevice::ReadResult::kEnd:
      EndRecording();
      return std::nullopt;
  }
  return std::nullopt;
}

void Openni2Camera::EndRecording() {
  finished_ = true;
  Close(CameraState::kLost,
        Format("the recording %s is over; the command \"restart\" plays it again",
               options_.device.value.c_str()));
}

void Openni2Camera::NoFrame() {
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

void Openni2Camera::CountFrame(int64_t now_us) {
  ++status_.num_captured;
  ++fps_frames_;
  const int64_t elapsed_us = now_us - fps_since_us_;
  if (elapsed_us < kFpsInterval) return;
  status_.fps = 1e6 * static_cast<double>(fps_frames_) / static_cast<double>(elapsed_us);
  fps_since_us_ = now_us;
  fps_frames_ = 0;
}

std::optional<CameraFrame> Openni2Camera::Convert(const RawFrame& raw, int64_t arrival_utime) {
  if (const std::string fault = FrameFault(raw, details_); !fault.empty()) {
    ++status_.num_bad;
    SetState(CameraState::kStreaming, Name() + ": " + fault);
    return std::nullopt;
  }
  SetState(CameraState::kStreaming, details_.note);
  CameraFrame frame;
  frame.model = model_;
  frame.registered = details_.registered;
  frame.depth_mm = DepthMillimetres(raw.depth, details_);
  if (!undistortion_.empty()) frame.depth_mm = Undistort(frame.depth_mm, undistortion_);
  if (raw.color) {
    frame.color_width = raw.color->width;
    frame.color_height = raw.color->height;
    frame.color_rgb = ColorRgb(*raw.color, details_);
  }
  frame.device_time_us = raw.depth.device_time_us;
  frame.frame_index = raw.depth.frame_index;
  frame.serial = status_.serial;
  frame.utime = details_.is_recording ? RecordingTime(frame.device_time_us)
                                      : clock_.Update(frame.device_time_us, arrival_utime);
  const double offset_us = details_.is_recording
                               ? static_cast<double>(frame.utime - frame.device_time_us)
                               : clock_.offset_us();
  status_.clock_offset_s = 1e-6 * offset_us;
  status_.clock_skew_ppm = details_.is_recording ? 0.0 : clock_.skew_ppm();
  status_.num_clock_steps = clock_.num_steps();
  return frame;
}

// A recording's frames keep the distances of its stamps, from the time when it began to play.
int64_t Openni2Camera::RecordingTime(int64_t device_us) {
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

std::string Openni2Camera::Name() const { return "device " + status_.serial; }

}  // namespace vantage
