#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "bus/image_conversion.h"
#include "common/result.h"
#include "tools/log/log_setup.h"
#include "tools/support/recorded_view.h"

namespace vantage {

struct LogImportParameters {
  std::string camera;  ///< <NAME> of the channels: 1 to 40 of A-Z a-z 0-9 _
  /// s from one view to the next; each takes 0.8 s of poses.
  double view_interval = 1.0;
  /// us since the epoch. Fixed, so that the same folder gives the same log.
  int64_t start_utime = 1'700'000'000'000'000;
  DepthCompression compression = DepthCompression::kVdc;
  LogSetup setup{};  ///< for LOG_HEADER

  /// Name as above, interval in [0.9, 3600], start in the years 1970 to 2200.
  Result<void> Validate() const;
};

struct LogImportSummary {
  int64_t num_views = 0;
  int64_t num_events = 0;
  int width = 0;   ///< px
  int height = 0;  ///< px
};

/// Writes the LCM log that a camera would have left that rested at each view in turn: LOG_HEADER
/// first, then for each view CAMERA_<NAME>_INFO, CAMERA_<NAME>_TO_WORLD at 100 Hz from 0.4 s before
/// to 0.4 s after, and CAMERA_<NAME> with its depth at the view's time. One view is in memory at a
/// time. The same input gives the same bytes; on errors no file is left. Errors: parameters, no
/// views, a depth image that is absent, no 16-bit grey PNG, larger than kMaxImageSide, or of
/// another size than the first; the system refuses.
Result<LogImportSummary> ImportViews(std::span<const RecordedView> views,
                                     const LogImportParameters& parameters,
                                     const std::filesystem::path& log);

}  // namespace vantage
