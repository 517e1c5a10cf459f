#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/camera/camera_frame.h"

namespace vantage {

/// What is wrong with a frame, in one sentence; empty when its images have the size that was agreed
/// on and hold as many bytes as that takes.
std::string FrameFault(const RawFrame& frame, const StreamDetails& details);

/// Depth in mm (rounded from finer units), rows from left to right; 0 where there is no
/// measurement. The frame has passed FrameFault().
std::vector<uint16_t> DepthMillimetres(const RawImage& depth, const StreamDetails& details);

/// A color image of utime 0, rows from left to right, its layout as it came. The frame has passed
/// FrameFault().
ColorImage ColorImageOf(const RawImage& color, const StreamDetails& details);

}  // namespace vantage
