#pragma once

#include <cstdint>

#include "nodes/handeye_file.h"
#include "perception/calibration/drift_check.h"
#include "vantage/handeye_check_t.hpp"
#include "vantage/handeye_result_t.hpp"

namespace vantage {

/// @param seq counts messages of the channel.
/// @param reason why the motions don't fix X and what to do; empty: they do.
handeye_result_t HandEyeToMessage(const HandEyeFile& calibration,
                                  int64_t seq,
                                  const std::string& reason);

/// @param source "target" or "detections". @param utime us since the epoch, of the last image used.
handeye_check_t DriftToMessage(const DriftReport& report,
                               const HandEyeFile& calibration,
                               const std::string& source,
                               int64_t utime,
                               int64_t seq);

}  // namespace vantage
