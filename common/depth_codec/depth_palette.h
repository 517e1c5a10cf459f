#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/depth_codec/depth_kernels.h"

namespace vantage {

/// The values that an image holds, other than 0, in ascending order. A structured-light sensor
/// knows few, one for each step of its disparity: by rank, neighbours differ by little.
class DepthPalette {
 public:
  static constexpr size_t kValues = 65536;

  DepthPalette();

  /// Finds the values of an image that is `width` px wide.
  void Build(std::span<const uint16_t> depth, size_t width, const DepthKernels& kernels);

  /// Number of values.
  [[nodiscard]] size_t size() const { return size_; }
  /// 1..size() of each value of the image that was built from, 0 of 0.
  [[nodiscard]] const uint16_t* ranks() const { return ranks_.get(); }
  /// Of each rank 0..size(); value 0 for rank 0. Readable up to kValues, to no purpose.
  [[nodiscard]] const uint16_t* values() const { return values_.get(); }

  /// Appends: number of values, then unless it is 0 the first one, their steps' common factor,
  /// a number k, and each further step divided by the factor, less 1, in Rice code with k bits.
  void Append(std::vector<uint8_t>* bytes) const;

  /// Reads that from the front of `bytes` and takes it off. @return false where it is none.
  bool Read(std::span<const uint8_t>* bytes);

 private:
  std::unique_ptr<uint8_t[]> present_;
  std::unique_ptr<uint16_t[]> ranks_;
  std::unique_ptr<uint16_t[]> values_;
  size_t size_ = 0;
};

}  // namespace vantage
