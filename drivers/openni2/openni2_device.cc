#include "drivers/openni2/openni2_device.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <utility>

#include "common/format.h"
#include "drivers/openni2/openni2_color.h"
#include "drivers/openni2/openni2_modes.h"
#include "drivers/openni2/usb_permission.h"

namespace vantage {
namespace {

using openni::VideoMode;

constexpr std::chrono::seconds kLockTimeout{5};
constexpr std::chrono::milliseconds kSyncPatience{350};  // without a frame; less than a stall
// A recording's next image comes at once or, at its end, never.
constexpr std::chrono::milliseconds kPlaybackPatience{500};
constexpr int kLongestWait = 60;  // depth images for which a recording waits for a pair

// A driver mirrors by default, and some can't but do: what still is mirrored is turned on arrival.
bool IsMirrored(openni::VideoStream& stream, bool is_recording) {
  // Of a recording the property tells how it was made, though it is said not to be supported;
  // setting it would only hide that.
  if (is_recording) return stream.getMirroringEnabled();
  if (!stream.isPropertySupported(openni::STREAM_PROPERTY_MIRRORING)) return false;
  stream.setMirroringEnabled(false);
  return stream.getMirroringEnabled();
}

// What another program left set.
void ResetCropping(openni::VideoStream& stream) {
  if (stream.isCroppingSupported()) stream.resetCropping();
}

int64_t Period(const VideoMode& mode) {
  return mode.getFps() > 0 ? 1'000'000 / mode.getFps() : 33'333;
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

void Add(const std::string& sentence, std::string* text) {
  *text += (text->empty() ? "" : "; ") + sentence;
}

std::atomic<bool> has_left_recordings = false;

}  // namespace

Result<std::unique_ptr<CameraDevice>> Openni2Device::Open(const std::string& uri,
                                                          DeviceEvents& events,
                                                          RecordTarget& record) {
  Result<std::unique_ptr<DeviceLock>> lock = DeviceLock::Acquire(uri, kLockTimeout);
  if (!lock) return lock.error();
  events.Forget(uri);
  std::unique_ptr<Openni2Device> device(new Openni2Device(uri, events, record));
  device->lock_ = std::move(lock).value();
  if (device->device_.open(uri.c_str()) != openni::STATUS_OK) {
    return device->Refusal("can't be opened");
  }
  return std::unique_ptr<CameraDevice>(std::move(device));
}

bool Openni2Device::HasLeftRecordings() { return has_left_recordings.load(); }

Openni2Device::~Openni2Device() {
  // Recording, frames, streams and device in this order, or the library frees them twice.
  recording_.reset();
  depth_frame_.release();
  next_depth_frame_.release();
  for (openni::VideoFrameRef& frame : color_frames_) frame.release();
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
  std::string hint = UsbPermissionHint(uri_);
  if (hint.empty()) hint = "is another program using it, and do udev rules let this user?";
  return {ErrorCode::kUnavailable,
          Format("device %s %s%s%s; %s",
                 uri_.c_str(),
                 what.c_str(),
                 reason.empty() ? "" : ": ",
                 reason.c_str(),
                 hint.c_str())};
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
  if (request.color && request.color_layout == PixelLayout::kJpeg) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("device %s: OpenNI2 gives no JPEG images, expected RGB or gray", uri_.c_str())};
  }
  StreamDetails details;
  is_recording_ = device_.isFile();
  details.is_recording = is_recording_;
  if (Result<void> started = StartDepth(request, &details); !started) return started.error();
  if (request.color) StartColor(request, &details);
  Register(request);
  OpenRecording();
  if (depth_.start() != openni::STATUS_OK) return Refusal("does not start its depth stream");
  if (color_.isValid()) StartColorStream(&details);
  // OpenNI2 says OK also where it does nothing, so the mode is read back.
  details.registered =
      device_.getImageRegistrationMode() == openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  if (is_recording_) PreparePlayback();
  last_frame_ = Clock::now();
  lock_.reset();
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
    const std::optional<VideoMode> mode = FindDepthMode(depth_.getSensorInfo(), request);
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
    ResetCropping(depth_);
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
  depth_period_us_ = Period(mode);
  return {};
}

void Openni2Device::StartColor(const StreamRequest& request, StreamDetails* details) {
  if (!device_.hasSensor(openni::SENSOR_COLOR) ||
      color_.create(device_, openni::SENSOR_COLOR) != openni::STATUS_OK) {
    Add("it has no color stream", &details->note);
    return;
  }
  if (!is_recording_) {
    const std::optional<VideoMode> mode = FindColorMode(color_.getSensorInfo(), request);
    if (mode) color_.setVideoMode(*mode);
    ResetCropping(color_);
  }
  const VideoMode mode = color_.getVideoMode();
  if (mode.getPixelFormat() != openni::PIXEL_FORMAT_RGB888 &&
      mode.getPixelFormat() != openni::PIXEL_FORMAT_GRAY8) {
    Add("it has no color stream in RGB or gray, only " + ModeList(color_.getSensorInfo()),
        &details->note);
    color_.destroy();
    return;
  }
  details->has_color = true;
  wants_gray_ = request.color_layout == PixelLayout::kGray8;
  flips_color_ = IsMirrored(color_, is_recording_) != details->mirrored;
  pairing_ = FramePairing({.depth_period_us = depth_period_us_,
                           .color_period_us = Period(mode),
                           .modulus_us = details->clock_modulus_us});
}

void Openni2Device::Register(const StreamRequest& request) {
  if (is_recording_) return;
  const openni::ImageRegistrationMode mode = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  // A device registers to color of depth's own size; to another size it is done afterwards.
  const bool same_size =
      !color_.isValid() ||
      (color_.getVideoMode().getResolutionX() == depth_.getVideoMode().getResolutionX() &&
       color_.getVideoMode().getResolutionY() == depth_.getVideoMode().getResolutionY());
  const bool wanted = request.registration == Registration::kDepthToColor && same_size &&
                      device_.isImageRegistrationModeSupported(mode);
  device_.setImageRegistrationMode(wanted ? mode : openni::IMAGE_REGISTRATION_OFF);
}

void Openni2Device::StartColorStream(StreamDetails* details) {
  if (color_.start() != openni::STATUS_OK) {
    details->has_color = false;
    Add("its color stream does not start", &details->note);
    const bool records = recording_ != nullptr;
    recording_.reset();
    color_.destroy();
    if (records) OpenRecording();
    return;
  }
  // Only once both stream does OpenNI2 ask the driver, few of which can. Where it can't, the
  // nearest image in time is taken, as it is of those that say they are synchronized.
  is_synced_ = !is_recording_ && device_.setDepthColorSyncEnabled(true) == openni::STATUS_OK;
}

void Openni2Device::PreparePlayback() {
  openni::PlaybackControl* playback = device_.getPlaybackControl();
  playback->setRepeatEnabled(false);
  // Each frame waits until the one before was read.
  playback->setSpeed(-1.0F);
  num_frames_ = playback->getNumberOfFrames(depth_);
  num_color_frames_ = color_.isValid() ? playback->getNumberOfFrames(color_) : 0;
}

// Reading.

// Reads one image of whichever stream has one, until `deadline`.
CameraDevice::ReadResult Openni2Device::ReadStreams(Clock::time_point deadline, Stream* read) {
  *read = Stream::kNone;
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
  // readFrame() without this wait blocks for ever where no frame comes any more.
  std::array<openni::VideoStream*, 2> streams = {&depth_, &color_};
  int ready = -1;
  const openni::Status status =
      openni::OpenNI::waitForAnyStream(streams.data(),
                                       color_.isValid() ? 2 : 1,
                                       &ready,
                                       static_cast<int>(std::max<int64_t>(left.count(), 0)));
  if (events_.IsGone(uri_)) return ReadResult::kGone;
  if (status == openni::STATUS_TIME_OUT) return ReadResult::kTimeout;
  if (status != openni::STATUS_OK) return ReadResult::kGone;
  openni::VideoFrameRef frame;
  openni::VideoStream& stream = ready == 1 ? color_ : depth_;
  if (stream.readFrame(&frame) != openni::STATUS_OK || !frame.isValid()) return ReadResult::kGone;
  if (ready == 1) {
    const int slot = pairing_.Offer(static_cast<int64_t>(frame.getTimestamp()));
    color_frames_[static_cast<size_t>(slot)] = frame;
    ++num_color_read_;
    *read = Stream::kColor;
  } else {
    next_depth_frame_ = frame;
    ++num_read_;
    *read = Stream::kDepth;
  }
  return ReadResult::kFrame;
}

CameraDevice::ReadResult Openni2Device::ReadDepth(Clock::time_point deadline) {
  while (!next_depth_frame_.isValid()) {
    Stream read = Stream::kNone;
    const ReadResult result = ReadStreams(deadline, &read);
    if (result != ReadResult::kFrame) return result;
  }
  depth_frame_ = next_depth_frame_;
  next_depth_frame_.release();
  return ReadResult::kFrame;
}

// The color image of a depth image may come a little after it. The next depth image ends the wait.
CameraDevice::ReadResult Openni2Device::ReadColorOfDepth() {
  const int64_t depth_us = static_cast<int64_t>(depth_frame_.getTimestamp());
  const auto deadline =
      Clock::now() + (is_recording_ ? std::chrono::microseconds(kPlaybackPatience)
                                    : std::chrono::microseconds(depth_period_us_));
  while (!next_depth_frame_.isValid() && pairing_.ShouldWait(depth_us) && Clock::now() < deadline) {
    if (is_recording_ && num_color_frames_ > 0 && num_color_read_ >= num_color_frames_) break;
    Stream read = Stream::kNone;
    if (ReadStreams(deadline, &read) == ReadResult::kGone) return ReadResult::kGone;
  }
  match_ = pairing_.Take(depth_us);
  return ReadResult::kFrame;
}

CameraDevice::ReadResult Openni2Device::Read(std::chrono::milliseconds timeout, RawFrame* frame) {
  *frame = {};
  if (events_.IsGone(uri_)) return ReadResult::kGone;
  if (is_recording_ && !next_depth_frame_.isValid() && num_frames_ > 0 &&
      num_read_ >= num_frames_) {
    return ReadResult::kEnd;
  }
  ReadResult result = ReadDepth(Clock::now() + timeout);
  if (result == ReadResult::kTimeout) {
    if (events_.HasEnded(uri_)) return ReadResult::kEnd;
    if (is_synced_ && Clock::now() - last_frame_ > kSyncPatience) StopSync();
  }
  if (result != ReadResult::kFrame) return result;
  last_frame_ = Clock::now();
  match_.reset();
  if (color_.isValid()) result = ReadColorOfDepth();
  if (result != ReadResult::kFrame) return result;
  FillFrame(frame);
  if (recording_ != nullptr) WatchRecording();
  frame->fault = trouble_;
  return ReadResult::kFrame;
}

void Openni2Device::FillFrame(RawFrame* frame) {
  frame->depth = Image(depth_frame_, PixelLayout::kDepth16);
  frame->index = depth_frame_.getFrameIndex();
  if (!match_) return;
  const openni::VideoFrameRef& color = color_frames_[static_cast<size_t>(match_->slot)];
  const bool is_gray = color.getVideoMode().getPixelFormat() == openni::PIXEL_FORMAT_GRAY8;
  frame->color = ConvertColor(Image(color, is_gray ? PixelLayout::kGray8 : PixelLayout::kRgb8),
                              wants_gray_,
                              flips_color_,
                              &color_pixels_);
  // Stamps that wrapped between the two are of one turn again.
  frame->color->device_time_us = frame->depth->device_time_us + match_->delay_us;
}

// OpenNI2 holds depth back for the color image of the same number; with one that never comes it
// gives neither. It swaps what its drivers deliver to without care for those that do, so they rest.
void Openni2Device::StopSync() {
  is_synced_ = false;
  color_.stop();
  depth_.stop();
  device_.setDepthColorSyncEnabled(false);
  depth_.start();
  color_.start();
  Add("no image came while OpenNI2 synchronized depth and color; it no longer does", &trouble_);
}

// Recording.

void Openni2Device::OpenRecording() {
  if (record_.file.empty() || is_recording_) return;
  Result<std::unique_ptr<OniRecording>> recording =
      OniRecording::Open(record_, record_.NextFile(), depth_, color_);
  if (!recording) {
    Add(recording.error().message, &trouble_);
    return;
  }
  recording_ = std::move(recording).value();
  // With color a recording begins between two pairs.
  if (!color_.isValid()) recording_->Begin();
}

void Openni2Device::BeginRecording() {
  const bool begun = recording_->Begin();
  std::array<openni::VideoStream*, 2> streams = {&depth_, &color_};
  int ready = -1;
  const bool quiet =
      openni::OpenNI::waitForAnyStream(streams.data(), 2, &ready, 0) == openni::STATUS_TIME_OUT;
  if (begun && quiet) return;
  // An image came meanwhile, which may or may not be in the file. Anew, after another pair.
  recording_->Discard();
  recording_.reset();
  --record_.num_files;  // Its name is free again.
  OpenRecording();
}

void Openni2Device::WatchRecording() {
  if (!recording_->has_begun()) {
    if (match_ && !next_depth_frame_.isValid()) {
      BeginRecording();
    } else if (++num_not_recorded_ == kLongestWait) {
      recording_->Begin();  // There are no pairs that could be torn.
    }
    return;
  }
  const std::string trouble = recording_->Trouble();
  if (trouble.empty()) return;
  recording_.reset();
  Add(trouble, &trouble_);
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

std::string Openni2Device::Describe() {
  std::string text;
  const struct {
    const char* name;
    openni::SensorType type;
  } sensors[] = {{"depth", openni::SENSOR_DEPTH},
                 {"color", openni::SENSOR_COLOR},
                 {"infrared", openni::SENSOR_IR}};
  for (const auto& [name, type] : sensors) {
    const openni::SensorInfo* sensor = device_.getSensorInfo(type);
    text += Format("  %s: %s\n", name, sensor == nullptr ? "none" : ModeList(*sensor).c_str());
  }
  const bool registers =
      device_.isImageRegistrationModeSupported(openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR);
  text += Format("  registers depth to color: %s\n", registers ? "yes, it says" : "no");
  openni::VideoStream depth;
  if (depth.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK) return text;
  const bool can_mirror = depth.isPropertySupported(openni::STREAM_PROPERTY_MIRRORING);
  text += Format(
      "  mirrored: %s\n",
      !can_mirror ? "no" : (IsMirrored(depth, false) ? "always; turned here" : "can be off"));
  depth.destroy();
  return text;
}

}  // namespace vantage
