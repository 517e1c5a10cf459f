#pragma once

#include <cstdint>
#include <vector>

#include "tests/drivers/v4l2_shim/description.h"

namespace vantage::v4l2_shim {

/// From one row to the next; 0 for JPEG.
uint32_t BytesPerLine(const Device& device, uint32_t fourcc, uint32_t width);
/// Bytes of the largest frame.
uint32_t SizeImage(const Device& device, uint32_t fourcc, uint32_t width, uint32_t height);

/// The frames that a device shows in turn: those of its file, or a period of test_scene.h. None for
/// a format that it can't draw or a size above 4096 px. Throws std::runtime_error: no such file.
std::vector<std::vector<uint8_t>> DrawFrames(const Device& device,
                                             uint32_t fourcc,
                                             uint32_t width,
                                             uint32_t height);

}  // namespace vantage::v4l2_shim
