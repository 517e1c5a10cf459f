#pragma once

#include <string>

#include "common/result.h"

namespace vantage {

/// Which device: "index:0" (place in the list of devices), "uri:...", "serial:...", "oni:file", or
/// one of V4L2's other names: "path:/dev/video0", "id:..." (of /dev/v4l/by-id), "bus:...".
struct DeviceSelector {
  enum class Kind { kIndex, kUri, kSerial, kRecording, kAlias };

  Kind kind = Kind::kIndex;
  int index = 0;      ///< for kIndex
  std::string value;  ///< URI, serial, path, or alias with its prefix

  /// Errors: another form, or an index outside 0..99.
  static Result<DeviceSelector> Parse(const std::string& text);
  /// As it was parsed.
  [[nodiscard]] std::string Text() const;
};

/// Errors: no such file, or none that begins as OpenNI2's recordings do.
Result<void> CheckRecording(const std::string& path);

}  // namespace vantage
