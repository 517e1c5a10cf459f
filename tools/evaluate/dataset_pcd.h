#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Points of a file of the Point Cloud Library, row by row.
struct PointCloud {
  int width = 0;                        ///< of a row; all points where they are in no order
  int height = 0;                       ///< 1 where they are in no order
  std::vector<Eigen::Vector3f> points;  ///< m, width * height; NaN where nothing was measured
};

/// Reads x, y and z (4-byte floats) of a PCD file of version 0.7, binary or binary_compressed;
/// other fields are passed over. Errors: absent, larger than 256 MiB, no PCD, no such fields, sizes
/// that disagree or are beyond 16384 x 16384 or 2^24 points, damaged.
Result<PointCloud> ReadPcd(const std::filesystem::path& file);

/// Undoes LZF compression (Lehmann's libLZF, the format that PCD files use): runs of literals and
/// references to bytes that are out already. Nothing when the bytes do not give exactly `size`.
std::optional<std::string> DecompressLzf(std::span<const uint8_t> bytes, size_t size);

}  // namespace vantage
