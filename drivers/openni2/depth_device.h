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
  std::string name;  ///< maker and product
};

/// What is asked of a device. A recording ignores size and rate: it has what was recorded.
struct StreamRequest {
  int width = 640;   ///< px
  int height = 480;  ///< px
  int fps = 30;      ///< Hz
  bool color = false;
  bool registration = false;  ///< depth in the colour camera's frame
};

/// What a device turned out to give.
struct StreamDetails {
  int width = 0;                ///< px, of depth
  int height = 0;               ///< px, of depth
  int depth_unit_um = 1000;     ///< um for a value of 1; 1000 or 100
  bool mirrored = false;        ///< rows run from right to left
  double horizontal_fov = 0.0;  ///< rad; 0: the device does not say
  double vertical_fov = 0.0;    ///< rad; 0: the device does not say
  bool registered = false;
  bool has_color = false;
  bool is_recording = false;
  std::string
      note;  ///< what was asked for and is lacking, in one sentence; empty when all is there
};

/// One image as the device gave it: nothing about it can be trusted. `data` lives until the next
/// Read().
struct RawImage {
  int width = 0;         ///< px
  int height = 0;        ///< px
  int stride_bytes = 0;  ///< from one row to the next
  std::span<const std::byte> data;
  int64_t device_time_us = 0;
  int frame_index = 0;
};

struct RawFrame {
  RawImage depth;                 ///< uint16, native byte order
  std::optional<RawImage> color;  ///< RGB, 8 bits each, of the same time
};

/// An open device. One thread uses it.
class DepthDevice {
 public:
  enum class ReadResult {
    kFrame,
    kTimeout,  ///< nothing came in time
    kGone,     ///< unplugged, or broken for good
    kEnd,      ///< of a recording
  };

  virtual ~DepthDevice() = default;

  /// Empty if the device has none.
  [[nodiscard]] virtual std::string serial() const = 0;
  /// Starts streaming. Errors: no such mode, or the device refuses.
  virtual Result<StreamDetails> Start(const StreamRequest& request) = 0;
  virtual ReadResult Read(std::chrono::milliseconds timeout, RawFrame* frame) = 0;
  /// Of the colour stream, us; 0: automatic. Errors: it has no such setting.
  virtual Result<void> SetExposure(int exposure_us) = 0;
  /// Of the colour stream, the device's unit. Errors: it has no such setting.
  virtual Result<void> SetGain(int gain) = 0;
};

/// The devices of this host, and the clocks beside which they run.
class DepthDeviceApi {
 public:
  virtual ~DepthDeviceApi() = default;

  virtual std::vector<DeviceListing> List() = 0;
  /// @param uri of List(), or a recording's path.
  virtual Result<std::unique_ptr<DepthDevice>> Open(const std::string& uri) = 0;
  /// Waits until a device is plugged in; false when none was after `timeout`.
  virtual bool WaitForDevice(std::chrono::milliseconds timeout) = 0;

  /// us; never set, only for differences.
  virtual int64_t MonotonicUs() = 0;
  /// us since the epoch; may be set at any time.
  virtual int64_t WallUs() = 0;
  virtual void Sleep(std::chrono::microseconds duration) = 0;
};

}  // namespace vantage
