#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A colour picture, 3 bytes a pixel, row by row.
struct RgbImage {
  int width = 0;             ///< px
  int height = 0;            ///< px
  std::vector<uint8_t> rgb;  ///< width * height * 3 values
};

/// A 16-bit grey picture, such as depth in millimetres.
struct Gray16Image {
  int width = 0;               ///< px
  int height = 0;              ///< px
  std::vector<uint16_t> gray;  ///< width * height values
};

/// An 8-bit grey picture, such as labels.
struct Gray8Image {
  int width = 0;              ///< px
  int height = 0;             ///< px
  std::vector<uint8_t> gray;  ///< width * height values
};

/// The same image gives the same bytes. Errors: sides outside 1..16384 px, a wrong number of
/// values.
Result<std::vector<uint8_t>> EncodePng(const RgbImage& image);
Result<std::vector<uint8_t>> EncodePng(const Gray16Image& image);

/// Whole or not at all. Errors: as EncodePng, or the system refuses.
Result<void> WritePng(const std::filesystem::path& file, const RgbImage& image);
Result<void> WritePng(const std::filesystem::path& file, const Gray16Image& image);

/// Errors: absent, larger than 256 MiB, no PNG, damaged, not 16-bit grey, sides beyond 16384 px.
Result<Gray16Image> ReadPng16(const std::filesystem::path& file);
/// The same of 8-bit grey.
Result<Gray8Image> ReadPng8(const std::filesystem::path& file);

}  // namespace vantage
