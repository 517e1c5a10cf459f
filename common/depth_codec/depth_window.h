#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vantage {

/// The part of an image beyond which nothing was measured.
struct DepthWindow {
  size_t left = 0;    ///< px
  size_t top = 0;     ///< px
  size_t width = 1;   ///< px
  size_t height = 1;  ///< px
};

/// The smallest window with all that was measured; one pixel where nothing was.
/// @param width px, 1..kMaxDepthSide, of the image; `depth` holds whole rows, at least one
DepthWindow FindDepthWindow(std::span<const uint16_t> depth, size_t width);

}  // namespace vantage
