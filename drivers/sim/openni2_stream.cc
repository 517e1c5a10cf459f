#include "drivers/sim/openni2_stream.h"

#include <cmath>
#include <cstring>
#include <utility>

#include "drivers/sim/openni2_property.h"

namespace vantage {
namespace {

constexpr int kFps = 30;
constexpr int kLargestDepth = 10000;  // mm

bool SameMode(const OniVideoMode& a, const OniVideoMode& b) {
  return a.pixelFormat == b.pixelFormat && a.resolutionX == b.resolutionX &&
         a.resolutionY == b.resolutionY && a.fps == b.fps;
}

float FieldOfView(int pixels, double focal_length) {
  return static_cast<float>(2.0 * std::atan(0.5 * pixels / focal_length));
}

}  // namespace

std::vector<OniVideoMode> SimVideoModes(OniSensorType sensor,
                                        const CameraModel& camera,
                                        const SimAbilities& abilities) {
  OniPixelFormat format = ONI_PIXEL_FORMAT_GRAY16;
  if (sensor == ONI_SENSOR_DEPTH) {
    format = abilities.fine_depth ? ONI_PIXEL_FORMAT_DEPTH_100_UM : ONI_PIXEL_FORMAT_DEPTH_1_MM;
  } else if (sensor == ONI_SENSOR_COLOR) {
    format = abilities.gray_color ? ONI_PIXEL_FORMAT_GRAY8 : ONI_PIXEL_FORMAT_RGB888;
  }
  std::vector<OniVideoMode> modes = {{format, camera.width, camera.height, kFps}};
  if (sensor != ONI_SENSOR_COLOR || !abilities.full_color_only) {
    modes.push_back({format, camera.width / 2, camera.height / 2, kFps});
  }
  return modes;
}

SimStream::SimStream(OniSensorType sensor,
                     const CameraModel& camera,
                     const SimAbilities& abilities,
                     std::function<void()> started)
    : sensor_(sensor),
      camera_(camera),
      abilities_(abilities),
      on_start_(std::move(started)),
      mode_(SimVideoModes(sensor, camera, abilities)[0]),
      mirroring_(CannotStopMirroring() || abilities.mirroring == SimAbilities::Mirroring::kOn
                     ? TRUE
                     : FALSE) {}

bool SimStream::CannotStopMirroring() const {
  return abilities_.mirroring == SimAbilities::Mirroring::kAlways ||
         (abilities_.mirroring == SimAbilities::Mirroring::kAlwaysDepth &&
          sensor_ == ONI_SENSOR_DEPTH);
}

int SimStream::BytesPerPixel() const {
  switch (mode_.pixelFormat) {
    case ONI_PIXEL_FORMAT_RGB888:
      return 3;
    case ONI_PIXEL_FORMAT_GRAY8:
      return 1;
    default:
      return 2;
  }
}

OniStatus SimStream::start() {
  started_ = true;
  on_start_();
  return ONI_STATUS_OK;
}

void SimStream::stop() {
  started_ = false;
  const std::lock_guard wait_for_delivery(delivering_);
}

OniStatus SimStream::getProperty(int property, void* data, int* size) {
  const std::lock_guard lock(mutex_);
  switch (property) {
    case ONI_STREAM_PROPERTY_CROPPING:
      return PutProperty(cropping_, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return PutProperty(FieldOfView(camera_.width, camera_.fx), data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return PutProperty(FieldOfView(camera_.height, camera_.fy), data, size);
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return PutProperty(mode_, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return PutProperty(sensor_ == ONI_SENSOR_DEPTH ? kLargestDepth : 255, data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return PutProperty(0, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return PutProperty(mode_.resolutionX * BytesPerPixel(), data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return PutProperty(mirroring_, data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus SimStream::setProperty(int property, const void* data, int size) {
  const std::lock_guard lock(mutex_);
  OniCropping cropping{};
  OniVideoMode mode{};
  switch (property) {
    case ONI_STREAM_PROPERTY_CROPPING:
      return TakeProperty(data, size, &cropping) ? SetCropping(cropping) : ONI_STATUS_BAD_PARAMETER;
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return TakeProperty(data, size, &mode) ? SetVideoMode(mode) : ONI_STATUS_BAD_PARAMETER;
    case ONI_STREAM_PROPERTY_MIRRORING:
      if (!TakeProperty(data, size, &mirroring_)) return ONI_STATUS_BAD_PARAMETER;
      if (CannotStopMirroring()) mirroring_ = TRUE;
      return ONI_STATUS_OK;
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniBool SimStream::isPropertySupported(int property) {
  return property >= ONI_STREAM_PROPERTY_CROPPING && property <= ONI_STREAM_PROPERTY_MIRRORING
             ? TRUE
             : FALSE;
}

OniStatus SimStream::SetCropping(const OniCropping& cropping) {
  if (cropping.enabled != FALSE &&
      (cropping.originX < 0 || cropping.originY < 0 || cropping.width < 1 || cropping.height < 1 ||
       cropping.width > mode_.resolutionX - cropping.originX ||
       cropping.height > mode_.resolutionY - cropping.originY)) {
    return ONI_STATUS_BAD_PARAMETER;
  }
  cropping_ = cropping;
  return ONI_STATUS_OK;
}

OniStatus SimStream::SetVideoMode(const OniVideoMode& mode) {
  if (started_) return ONI_STATUS_OUT_OF_FLOW;
  for (const OniVideoMode& supported : SimVideoModes(sensor_, camera_, abilities_)) {
    if (!SameMode(mode, supported)) continue;
    mode_ = supported;
    cropping_ = {};
    return ONI_STATUS_OK;
  }
  return ONI_STATUS_NOT_SUPPORTED;
}

int SimStream::width() {
  const std::lock_guard lock(mutex_);
  return mode_.resolutionX;
}

void SimStream::Deliver(
    const void* pixels, size_t bytes, uint64_t timestamp, int index, const SimFrameFaults& faults) {
  const std::lock_guard delivering(delivering_);
  if (!started_) return;
  OniFrame* frame = getServices().acquireFrame();
  if (frame == nullptr) return;
  frame->timestamp = timestamp;
  frame->frameIndex = index;
  if (FillFrame(static_cast<const uint8_t*>(pixels), bytes, frame)) {
    Spoil(faults, frame);
    raiseNewFrame(frame);
  }
  getServices().releaseFrame(frame);
}

void SimStream::Spoil(const SimFrameFaults& faults, OniFrame* frame) {
  if (faults.is_short) frame->dataSize /= 2;
  if (faults.has_no_data) {
    withheld_.emplace_back(std::exchange(frame->data, nullptr), &std::free);
    frame->dataSize = 0;
  }
  if (faults.is_resized) {
    frame->width /= 2;
    frame->stride /= 2;
    frame->dataSize /= 2;
  }
  if (faults.is_absurd) {
    frame->width = INT32_MAX;
    frame->height = -1;
    frame->stride = INT32_MIN;
  }
}

bool SimStream::FillFrame(const uint8_t* pixels, size_t bytes, OniFrame* frame) {
  const std::lock_guard lock(mutex_);
  const auto expected =
      static_cast<size_t>(mode_.resolutionX * mode_.resolutionY * BytesPerPixel());
  if (bytes != expected) return false;  // The mode changed in the meantime.
  const bool cropped = cropping_.enabled != FALSE;
  frame->sensorType = sensor_;
  frame->videoMode = mode_;
  frame->croppingEnabled = cropped ? TRUE : FALSE;
  frame->cropOriginX = cropped ? cropping_.originX : 0;
  frame->cropOriginY = cropped ? cropping_.originY : 0;
  frame->width = cropped ? cropping_.width : mode_.resolutionX;
  frame->height = cropped ? cropping_.height : mode_.resolutionY;
  frame->stride = frame->width * BytesPerPixel();
  frame->dataSize = frame->stride * frame->height;
  CopyPixels(pixels, *frame);
  return true;
}

void SimStream::CopyPixels(const uint8_t* pixels, const OniFrame& frame) const {
  const auto pixel = static_cast<size_t>(BytesPerPixel());
  const auto source_stride = static_cast<size_t>(mode_.resolutionX) * pixel;
  auto* out = static_cast<uint8_t*>(frame.data);
  for (int v = 0; v < frame.height; ++v) {
    const uint8_t* row = pixels + static_cast<size_t>(v + frame.cropOriginY) * source_stride;
    if (mirroring_ == FALSE) {
      const size_t bytes = static_cast<size_t>(frame.width) * pixel;
      std::memcpy(out, row + static_cast<size_t>(frame.cropOriginX) * pixel, bytes);
      out += bytes;
      continue;
    }
    for (int u = 0; u < frame.width; ++u, out += pixel) {
      const int from = mode_.resolutionX - 1 - frame.cropOriginX - u;
      std::memcpy(out, row + static_cast<size_t>(from) * pixel, pixel);
    }
  }
}

}  // namespace vantage
