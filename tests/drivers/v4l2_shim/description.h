#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vantage::v4l2_shim {

struct Fraction {
  uint32_t numerator = 0;
  uint32_t denominator = 0;
};

/// A line "format" or "stepwise": what one pixel format offers.
struct FormatMode {
  uint32_t fourcc = 0;
  uint32_t width = 0;   ///< px; the least of a stepwise one
  uint32_t height = 0;  ///< px, alike
  bool stepwise = false;
  uint32_t max_width = 0;       ///< px
  uint32_t max_height = 0;      ///< px
  uint32_t step = 1;            ///< px
  std::vector<Fraction> rates;  ///< Hz
};

struct ControlValue {
  std::string name;  ///< of KnownControls()
  int32_t minimum = 0;
  int32_t maximum = 0;
  int32_t step = 1;
  int32_t initial = 0;
};

/// Which frames since STREAMON a fault is for.
struct When {
  enum class Kind { kAlways, kEvery, kAt, kAfter };
  Kind kind = Kind::kAlways;
  uint64_t number = 0;

  [[nodiscard]] bool Includes(uint64_t frame) const;
};

/// A line "fault": frames that are not as they should be.
struct FrameFault {
  std::string name;
  int64_t value = 0;
  When when;
};

/// A line "fail": calls that fail.
struct CallFault {
  std::string call;  ///< "OPEN", "MMAP", or an ioctl without its VIDIOC_
  int error = 0;     ///< errno
  int times = 0;     ///< 0: always
  std::string line;  ///< as it was written
};

/// A line "override": a number that the device answers instead of its own.
struct Override {
  std::string field;
  uint32_t value = 0;
};

/// One device node.
struct Device {
  enum class Kind { kCapture, kOutput, kMetadata, kNull, kFile };

  int number = 0;  ///< of /dev/video<number>
  Kind kind = Kind::kCapture;
  std::string driver = "uvcvideo";
  std::string card = "Emulated Camera";
  std::string serial;  ///< empty: none
  int port = 0;        ///< of the USB device; nodes of one port are of one device
  int index = 0;       ///< of the node within its USB device
  double speed = 1.0;  ///< frames come so many times as often as the rate says
  bool jpeg_tables = true;
  uint32_t padding_bytes = 0;  ///< after each row
  std::string frames_file;     ///< raw frames of the image's size, shown in turn; empty: a pattern
  std::vector<FormatMode> formats;
  std::vector<ControlValue> controls;
  std::vector<FrameFault> faults;
  std::vector<CallFault> fails;
  std::vector<Override> overrides;

  [[nodiscard]] std::string bus() const;
  /// The value that an override gives to the field, or else `value`.
  [[nodiscard]] uint32_t Answer(const std::string& field, uint32_t value) const;
  /// The fault that the frame has; null: it does not have it.
  [[nodiscard]] const FrameFault* Fault(const std::string& name, uint64_t frame) const;
};

/// Reads the text of which description.cc tells. Throws std::runtime_error, which names the line.
std::vector<Device> ParseDescription(const std::string& text);

}  // namespace vantage::v4l2_shim
