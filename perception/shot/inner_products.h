#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/simd.h"

namespace vantage {

/// A fixed set of vectors, laid out for their inner products with others.
class InnerProducts {
 public:
  InnerProducts() = default;
  /// @param vectors one after the other, each of `dimension` values.
  InnerProducts(std::span<const float> vectors, size_t dimension);

  [[nodiscard]] size_t dimension() const { return dimension_; }
  /// How many vectors there are, rounded up to whole blocks of kBlock; the rest are zeros.
  [[nodiscard]] size_t stride() const { return num_blocks_ * kBlock; }

  /// products[i * stride() + j] = queries[i] . vectors[j]. The same on every processor.
  /// @param queries one after the other, each of dimension() values.
  void Compute(std::span<const float> queries, std::vector<float>* products) const;

  static constexpr size_t kBlock = 2 * static_cast<size_t>(kLanes);

 private:
  size_t dimension_ = 0;
  size_t num_blocks_ = 0;
  std::vector<float> blocks_;  // Of kBlock vectors: first values of all, second values ...
};

}  // namespace vantage
