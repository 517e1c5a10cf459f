#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/openni2/depth_device.h"

namespace vantage {

/// What is wrong with a frame, in one sentence; empty when its images have the size that was agreed
/// on and hold as many bytes as that takes.
std::string FrameFault(const RawFrame& frame, const StreamDetails& details);

/// Depth in mm (rounded from finer units), rows from left to right; 0 where there is no
/// measurement. The frame has passed FrameFault().
std::vector<uint16_t> DepthMillimetres(const RawImage& depth, const StreamDetails& details);

/// RGB, rows from left to right. The frame has passed FrameFault().
std::vector<uint8_t> ColorRgb(const RawImage& color, const StreamDetails& details);

}  // namespace vantage
