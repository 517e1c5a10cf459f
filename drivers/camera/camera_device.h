#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A device that could be opened.
struct DeviceListing {
  std::string uri;
  std::string name;                  ///< maker and product
  std::string serial;                ///< empty: only the open device tells, or none
  std::vector<std::string> aliases;  ///< other names as DeviceSelector has them, "id:..." for one
};

/// How the pixels of an image lie in memory.
enum class PixelLayout {
  kDepth16,  ///< uint16, native byte order
  kRgb8,     ///< three bytes a pixel
  kGray8,    ///< one byte a pixel
  kJpeg,     ///< a JPEG file
};

/// Which image is moved into the frame of the other's camera.
enum class Registration { kNone, kDepthToColor, kColorToDepth };

/// What is asked of a device. A recording ignores size and rate: it has what was recorded.
struct StreamRequest {
  int width = 640;     ///< px
  int height = 480;    ///< px
  int fps = 30;        ///< Hz
  bool color = false;  ///< beside the depth
  PixelLayout color_layout = PixelLayout::kRgb8;
  Registration registration = Registration::kNone;
};

/// What a device turned out to give.
struct StreamDetails {
  int width = 0;   ///< px, of depth; of color where there is no depth
  int height = 0;  ///< px, alike
  bool has_depth = true;
  bool has_color = false;
  int depth_unit_um = 1000;              ///< um for a value of 1: 1 to 1,000,000
  bool mirrored = false;                 ///< rows run from right to left
  double horizontal_fov = 0.0;           ///< rad; 0: the device does not say
  double vertical_fov = 0.0;             ///< rad; 0: the device does not say
  bool registered = false;               ///< depth comes in the color camera's frame
  int64_t clock_modulus_us = 1LL << 32;  ///< us at which its stamps wrap around; 0: they don't
  bool is_recording = false;
  std::string
      note;  ///< what was asked for and is lacking, in one sentence; empty when all is there
};

/// One image as the device gave it: nothing about it can be trusted. `data` lives until the next
/// Read().
struct RawImage {
  PixelLayout layout = PixelLayout::kDepth16;
  int width = 0;         ///< px
  int height = 0;        ///< px
  int stride_bytes = 0;  ///< from one row to the next; 0 for kJpeg
  std::span<const std::byte> data;
  int64_t device_time_us = 0;
};

/// What came at once. Depth, color or both; both are of the same time, to half a frame's period.
struct RawFrame {
  std::optional<RawImage> depth;
  std::optional<RawImage> color;
  int64_t index = -1;  ///< as the device counts its frames; a gap is a loss; -1: it does not count
  /// Of ReadResult::kBad: why, in one sentence. Of a good frame: what else is wrong by now, such as
  /// a recording that had to end.
  std::string fault;
};

/// An open device. One thread uses it.
class CameraDevice {
 public:
  enum class ReadResult {
    kFrame,
    kBad,      ///< a frame that can't be used: `fault` says why, `index` is set, no images
    kTimeout,  ///< nothing came in time
    kGone,     ///< unplugged, or broken for good
    kEnd,      ///< of a recording
  };

  virtual ~CameraDevice() = default;

  /// Empty if the device has none.
  [[nodiscard]] virtual std::string serial() const = 0;
  /// Starts streaming. Errors: no such mode, or the device refuses.
  virtual Result<StreamDetails> Start(const StreamRequest& request) = 0;
  virtual ReadResult Read(std::chrono::milliseconds timeout, RawFrame* frame) = 0;
  /// us; 0: automatic. Errors: it has no such setting.
  virtual Result<void> SetExposure(int exposure_us) = 0;
  /// The device's unit. Errors: it has no such setting.
  virtual Result<void> SetGain(int gain) = 0;
  /// A setting by the device's name for it, in its unit. Errors: it has none of that name (which
  /// names those there are), or refuses the value.
  virtual Result<void> SetControl(const std::string& name, int64_t value) = 0;
};

/// The devices of this host, and the clocks beside which they run.
class CameraDeviceApi {
 public:
  virtual ~CameraDeviceApi() = default;

  /// "OpenNI2", "V4L2": for messages.
  [[nodiscard]] virtual std::string name() const = 0;
  /// What to look at when a device is not found, as the end of a sentence.
  [[nodiscard]] virtual std::string search_hint() const = 0;

  virtual std::vector<DeviceListing> List() = 0;
  /// @param uri of List(), or a recording's path.
  virtual Result<std::unique_ptr<CameraDevice>> Open(const std::string& uri) = 0;
  /// Waits until a device is plugged in; false when none was after `timeout`.
  virtual bool WaitForDevice(std::chrono::milliseconds timeout) = 0;

  /// us; never set, only for differences.
  virtual int64_t MonotonicUs();
  /// us since the epoch; may be set at any time.
  virtual int64_t WallUs();
  virtual void Sleep(std::chrono::microseconds duration);
};

}  // namespace vantage
