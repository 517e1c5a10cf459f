#pragma once

#include <cstddef>
#include <vector>

#include "drivers/camera/camera_device.h"

namespace vantage {

/// The image as gray where it is RGB and `to_gray` is set (luma of ITU-R BT.601), its rows turned
/// where `flip` is set. Its data is then in `buffer`. An image whose bytes are not those of its
/// size, or that needs nothing done, comes back as it is.
RawImage ConvertColor(const RawImage& image,
                      bool to_gray,
                      bool flip,
                      std::vector<std::byte>* buffer);

}  // namespace vantage
