#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vantage {

/// A pixel format of V4L2 that this driver reads.
struct PixelFormat {
  enum class Kind { kDepth, kColor };

  uint32_t fourcc = 0;
  const char* name = "";  ///< as the configuration has it
  Kind kind = Kind::kColor;
  int bits = 0;  ///< of a pixel; 0: compressed
};

/// Null: not one that this driver reads.
const PixelFormat* FindPixelFormat(uint32_t fourcc);
const PixelFormat* FindPixelFormat(const std::string& name);

/// All that this driver reads, the preferred ones first.
std::vector<std::string> PixelFormatNames();

/// The four characters, without spaces at the end; what can't be printed as '?'.
std::string FourccText(uint32_t fourcc);

/// Bytes of a row without what comes after its last pixel. @param width px
int64_t RowBytes(const PixelFormat& format, int width);

}  // namespace vantage
