#include "drivers/openni2/openni2_device.h"

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "common/format.h"

namespace vantage {
namespace {

using openni::VideoMode;

const char* FormatName(openni::PixelFormat format) {
  switch (format) {
    case openni::PIXEL_FORMAT_DEPTH_1_MM:
      return "1 mm";
    case openni::PIXEL_FORMAT_DEPTH_100_UM:
      return "0.1 mm";
    default:
      return "another format";
  }
}

std::optional<VideoMode> FindMode(const openni::SensorInfo& sensor,
                                  const StreamRequest& request,
                                  openni::PixelFormat format) {
  const openni::Array<VideoMode>& modes = sensor.getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    if (modes[i].getResolutionX() == request.width && modes[i].getResolutionY() == request.height &&
        modes[i].getFps() == request.fps && modes[i].getPixelFormat() == format) {
      return modes[i];
    }
  }
  return std::nullopt;
}

bool SameMode(const VideoMode& a, const VideoMode& b) {
  return a.getResolutionX() == b.getResolutionX() && a.getResolutionY() == b.getResolutionY() &&
         a.getFps() == b.getFps() && a.getPixelFormat() == b.getPixelFormat();
}

std::string ModeList(const openni::SensorInfo& sensor) {
  std::string list;
  const openni::Array<VideoMode>& modes = sensor.getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    list += Format("%s%dx%d at %d Hz in %s",
                   i == 0 ? "" : ", ",
                   modes[i].getResolutionX(),
                   modes[i].getResolutionY(),
                   modes[i].getFps(),
                   FormatName(modes[i].getPixelFormat()));
  }
  return list.empty() ? "none" : list;
}

// A driver mirrors by default, and some can't but do: what still is mirrored is turned on arrival.
bool IsMirrored(openni::VideoStream& stream, bool is_recording) {
  if (!stream.isPropertySupported(openni::STREAM_PROPERTY_MIRRORING)) return false;
  // Of a recording the property tells how it was made; setting it would only hide that.
  if (!is_recording) stream.setMirroringEnabled(false);
  return stream.getMirroringEnabled();
}

RawImage Image(const openni::VideoFrameRef& frame, PixelLayout layout) {
  RawImage image;
  image.layout = layout;
  image.width = frame.getWidth();
  image.height = frame.getHeight();
  image.stride_bytes = frame.getStrideInBytes();
  if (frame.getData() != nullptr && frame.getDataSize() > 0) {
    image.data = {static_cast<const std::byte*>(frame.getData()),
                  static_cast<size_t>(frame.getDataSize())};
  }
  image.device_time_us = static_cast<int64_t>(frame.getTimestamp());
  return image;
}

void AddNote(const std::string& sentence, StreamDetails* details) {
  details->note += (details->note.empty() ? "" : "; ") + sentence;
}

std::atomic<bool> has_left_recordings = false;

}  // namespace

Result<std::unique_ptr<CameraDevice>> Openni2Device::Open(const std::string& uri,
                                                          DeviceEvents& events) {
  events.Forget(uri);
  std::unique_ptr<Openni2Device> device(new Openni2Device(uri, events));
  if (device->device_.open(uri.c_str()) != openni::STATUS_OK) {
    return device->Refusal("can't be opened");
  }
  return std::unique_ptr<CameraDevice>(std::move(device));
}

bool Openni2Device::HasLeftRecordings() { return has_left_recordings.load(); }

Openni2Device::~Openni2Device() {
  // Frames, streams and device in this order, or the library frees them twice.
  depth_frame_.release();
  color_frame_.release();
  if (is_recording_) {
    // OniFile's player thread uses its streams while they are destroyed, and crashes one time in
    // 25 (2.2.0.33). Left alone it waits for a read that never comes; some 100 kB a recording.
    static_cast<void>(handles_.release());
    has_left_recordings = true;
    return;
  }
  color_.stop();
  depth_.stop();
  color_.destroy();
  depth_.destroy();
  device_.close();
}

Error Openni2Device::Refusal(const std::string& what) const {
  std::string reason = openni::OpenNI::getExtendedError();
  while (!reason.empty() && (reason.back() == '\n' || reason.back() == ' ')) reason.pop_back();
  for (char& c : reason) {
    if (c == '\n' || c == '\t') c = ' ';
  }
  return {ErrorCode::kUnavailable,
          Format("device %s %s%s%s; is another program using it, and do udev rules let this user?",
                 uri_.c_str(),
                 what.c_str(),
                 reason.empty() ? "" : ": ",
                 reason.c_str())};
}

std::string Openni2Device::serial() const {
  std::array<char, 256> text{};
  int size = static_cast<int>(text.size()) - 1;
  if (device_.getProperty(openni::DEVICE_PROPERTY_SERIAL_NUMBER, text.data(), &size) !=
      openni::STATUS_OK) {
    return {};
  }
  std::string serial;
  for (const char* c = text.data(); *c != '\0'; ++c) {
    if (*c > ' ' && *c <= '~') serial += *c;
  }
  return serial;
}

Result<StreamDetails> Openni2Device::Start(const StreamRequest& request) {
  StreamDetails details;
  is_recording_ = device_.isFile();
  details.is_recording = is_recording_;
  if (Result<void> started = StartDepth(request, &details); !started) return started.error();
  if (request.color) StartColor(request, &details);
  if (request.registration == Registration::kDepthToColor && !is_recording_) {
    Register(&details);
  } else {
    details.registered =
        device_.getImageRegistrationMode() == openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  }
  if (depth_.start() != openni::STATUS_OK) return Refusal("does not start its depth stream");
  if (color_.isValid() && color_.start() != openni::STATUS_OK) {
    color_.destroy();
    details.has_color = false;
    AddNote("its color stream does not start", &details);
  }
  if (is_recording_) {
    openni::PlaybackControl* playback = device_.getPlaybackControl();
    playback->setRepeatEnabled(false);
    // Each frame waits until the one before was read.
    playback->setSpeed(-1.0F);
    num_frames_ = playback->getNumberOfFrames(depth_);
  }
  return details;
}

Result<void> Openni2Device::StartDepth(const StreamRequest& request, StreamDetails* details) {
  if (!device_.hasSensor(openni::SENSOR_DEPTH)) {
    return Error{ErrorCode::kNotFound, Format("device %s has no depth sensor", uri_.c_str())};
  }
  if (depth_.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK) {
    return Refusal("gives no depth stream");
  }
  if (!is_recording_) {
    std::optional<VideoMode> mode =
        FindMode(depth_.getSensorInfo(), request, openni::PIXEL_FORMAT_DEPTH_1_MM);
    if (!mode) {
      mode = FindMode(depth_.getSensorInfo(), request, openni::PIXEL_FORMAT_DEPTH_100_UM);
    }
    if (!mode) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("device %s has no depth mode of %dx%d at %d Hz, expected one of: %s",
                          uri_.c_str(),
                          request.width,
                          request.height,
                          request.fps,
                          ModeList(depth_.getSensorInfo()).c_str())};
    }
    // Some drivers with a single mode refuse to have it set.
    if (depth_.setVideoMode(*mode) != openni::STATUS_OK &&
        !SameMode(depth_.getVideoMode(), *mode)) {
      return Refusal("refuses its own mode");
    }
  }
  const VideoMode mode = depth_.getVideoMode();
  if (mode.getPixelFormat() != openni::PIXEL_FORMAT_DEPTH_1_MM &&
      mode.getPixelFormat() != openni::PIXEL_FORMAT_DEPTH_100_UM) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("device %s gives depth in format %d, expected 100 (1 mm) or 101 (0.1 mm)",
                        uri_.c_str(),
                        static_cast<int>(mode.getPixelFormat()))};
  }
  details->width = mode.getResolutionX();
  details->height = mode.getResolutionY();
  details->depth_unit_um = mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM ? 1000 : 100;
  details->mirrored = IsMirrored(depth_, is_recording_);
  details->horizontal_fov = static_cast<double>(depth_.getHorizontalFieldOfView());
  details->vertical_fov = static_cast<double>(depth_.getVerticalFieldOfView());
  if (mode.getFps() > 0) period_us_ = 1'000'000 / mode.getFps();
  return {};
}

void Openni2Device::StartColor(const StreamRequest& request, StreamDetails* details) {
  if (!device_.hasSensor(openni::SENSOR_COLOR) ||
      color_.create(device_, openni::SENSOR_COLOR) != openni::STATUS_OK) {
    AddNote("it has no color stream", details);
    return;
  }
  const std::optional<VideoMode> mode =
      FindMode(color_.getSensorInfo(), request, openni::PIXEL_FORMAT_RGB888);
  const bool set =
      is_recording_ || (mode.has_value() && color_.setVideoMode(*mode) == openni::STATUS_OK);
  if (!set || color_.getVideoMode().getPixelFormat() != openni::PIXEL_FORMAT_RGB888 ||
      IsMirrored(color_, is_recording_) != details->mirrored) {
    color_.destroy();
    AddNote("it has no color stream in RGB of depth's size and rate", details);
    return;
  }
  details->has_color = true;
  // Not all devices can; without it the nearest image in time is taken.
  device_.setDepthColorSyncEnabled(true);
}

void Openni2Device::Register(StreamDetails* details) {
  const openni::ImageRegistrationMode mode = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  if (device_.isImageRegistrationModeSupported(mode)) device_.setImageRegistrationMode(mode);
  // OpenNI2 says OK also where it does nothing, so the mode is read back.
  details->registered = device_.getImageRegistrationMode() == mode;
  if (!details->registered) AddNote("it can't register depth to color", details);
}

bool Openni2Device::ReadStream(openni::VideoStream& stream, openni::VideoFrameRef* frame) {
  return stream.readFrame(frame) == openni::STATUS_OK && frame->isValid();
}

CameraDevice::ReadResult Openni2Device::Read(std::chrono::milliseconds timeout, RawFrame* frame) {
  *frame = {};
  if (events_.IsGone(uri_)) return ReadResult::kGone;
  if (is_recording_ && num_frames_ > 0 && num_read_ >= num_frames_) return ReadResult::kEnd;
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (auto left = timeout; left.count() >= 0;
       left = std::chrono::duration_cast<std::chrono::milliseconds>(
           deadline - std::chrono::steady_clock::now())) {
    // readFrame() without this wait blocks for ever where no frame comes any more.
    std::array<openni::VideoStream*, 2> streams = {&depth_, &color_};
    int ready = -1;
    const openni::Status status = openni::OpenNI::waitForAnyStream(
        streams.data(), color_.isValid() ? 2 : 1, &ready, static_cast<int>(left.count()));
    if (events_.IsGone(uri_)) return ReadResult::kGone;
    if (status == openni::STATUS_TIME_OUT) break;
    if (status != openni::STATUS_OK) return ReadResult::kGone;
    if (ready == 1) {
      if (!ReadStream(color_, &color_frame_)) return ReadResult::kGone;
      continue;
    }
    if (!ReadStream(depth_, &depth_frame_)) return ReadResult::kGone;
    ++num_read_;
    frame->depth = Image(depth_frame_, PixelLayout::kDepth16);
    frame->index = depth_frame_.getFrameIndex();
    if (color_.isValid()) {
      WaitForColor();
      const int64_t half_us = period_us_ / 2;
      if (color_frame_.isValid()) {
        const RawImage color = Image(color_frame_, PixelLayout::kRgb8);
        if (std::abs(color.device_time_us - frame->depth->device_time_us) <= half_us) {
          frame->color = color;
        }
      }
    }
    return ReadResult::kFrame;
  }
  return events_.HasEnded(uri_) ? ReadResult::kEnd : ReadResult::kTimeout;
}

// The color image of a depth image may come a little after it.
void Openni2Device::WaitForColor() {
  const uint64_t depth_us = depth_frame_.getTimestamp();
  const uint64_t half_us = static_cast<uint64_t>(period_us_ / 2);
  if (color_frame_.isValid() && color_frame_.getTimestamp() + half_us >= depth_us) return;
  openni::VideoStream* stream = &color_;
  int ready = -1;
  const int timeout_ms = static_cast<int>(half_us / 1000);
  if (openni::OpenNI::waitForAnyStream(&stream, 1, &ready, timeout_ms) == openni::STATUS_OK) {
    ReadStream(color_, &color_frame_);
  }
}

Result<openni::CameraSettings*> Openni2Device::ColorSettings() {
  openni::CameraSettings* settings = color_.isValid() ? color_.getCameraSettings() : nullptr;
  if (settings == nullptr) {
    return Error{
        ErrorCode::kUnavailable,
        Format("device %s has no camera settings, which belong to its color stream", uri_.c_str())};
  }
  return settings;
}

Result<void> Openni2Device::SetExposure(int exposure_us) {
  Result<openni::CameraSettings*> settings = ColorSettings();
  if (!settings) return settings.error();
  const bool automatic = exposure_us == 0;
  if ((*settings)->setAutoExposureEnabled(automatic) != openni::STATUS_OK ||
      (!automatic && (*settings)->setExposure(exposure_us) != openni::STATUS_OK)) {
    return Error{ErrorCode::kUnavailable,
                 Format("device %s refuses an exposure of %d us", uri_.c_str(), exposure_us)};
  }
  return {};
}

Result<void> Openni2Device::SetGain(int gain) {
  Result<openni::CameraSettings*> settings = ColorSettings();
  if (!settings) return settings.error();
  if ((*settings)->setGain(gain) != openni::STATUS_OK) {
    return Error{ErrorCode::kUnavailable,
                 Format("device %s refuses a gain of %d", uri_.c_str(), gain)};
  }
  return {};
}

Result<void> Openni2Device::SetControl(const std::string& name, int64_t value) {
  Result<openni::CameraSettings*> settings = ColorSettings();
  if (!settings) return settings.error();
  openni::Status status = openni::STATUS_OK;
  if (name == "auto_exposure") {
    status = (*settings)->setAutoExposureEnabled(value != 0);
  } else if (name == "auto_white_balance") {
    status = (*settings)->setAutoWhiteBalanceEnabled(value != 0);
  } else {
    return Error{ErrorCode::kNotFound,
                 Format("device %s has no control %s, expected auto_exposure or auto_white_balance",
                        uri_.c_str(),
                        name.c_str())};
  }
  if (status != openni::STATUS_OK) {
    return Error{ErrorCode::kUnavailable,
                 Format("device %s refuses %s = %lld",
                        uri_.c_str(),
                        name.c_str(),
                        static_cast<long long>(value))};
  }
  return {};
}

}  // namespace vantage
