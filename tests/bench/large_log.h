#pragma once

#include <cstdint>
#include <filesystem>

#include "common/result.h"

namespace vantage {

/// Writes a log as a set-up with one camera records it, of at least so many bytes: compressed depth
/// at 10 Hz, poses at 100 Hz, detections, estimates, states; about 2.5 kB an event.
/// Errors: the writer's.
Result<void> WriteLargeLog(const std::filesystem::path& file, int64_t num_bytes);

}  // namespace vantage
