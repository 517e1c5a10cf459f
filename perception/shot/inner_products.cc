#include "perception/shot/inner_products.h"

#include <algorithm>
#include <cstring>

#include "common/check.h"

namespace vantage {
namespace {

constexpr size_t kRows = 4;  // Queries at once: so many sums fit into the registers.

}  // namespace

InnerProducts::InnerProducts(std::span<const float> vectors, size_t dimension)
    : dimension_(dimension) {
  VANTAGE_CHECK(dimension > 0 && vectors.size() % dimension == 0, "vectors of one length");
  const size_t count = vectors.size() / dimension;
  num_blocks_ = (count + kBlock - 1) / kBlock;
  blocks_.assign(num_blocks_ * kBlock * dimension, 0.0F);
  for (size_t i = 0; i < count; ++i) {
    float* block = blocks_.data() + i / kBlock * kBlock * dimension;
    for (size_t d = 0; d < dimension; ++d) {
      block[d * kBlock + i % kBlock] = vectors[i * dimension + d];
    }
  }
}

VANTAGE_SIMD static void MultiplyBlock(const float* block,
                                       size_t dimension,
                                       const float* const* queries,
                                       float* const* products) {
  F8 low0{}, low1{}, low2{}, low3{}, high0{}, high1{}, high2{}, high3{};
  for (size_t d = 0; d < dimension; ++d) {
    F8 low;
    F8 high;
    std::memcpy(&low, block + d * InnerProducts::kBlock, sizeof(F8));
    std::memcpy(&high, block + d * InnerProducts::kBlock + kLanes, sizeof(F8));
    low0 += queries[0][d] * low;
    high0 += queries[0][d] * high;
    low1 += queries[1][d] * low;
    high1 += queries[1][d] * high;
    low2 += queries[2][d] * low;
    high2 += queries[2][d] * high;
    low3 += queries[3][d] * low;
    high3 += queries[3][d] * high;
  }
  const F8 sums[kRows][2] = {{low0, high0}, {low1, high1}, {low2, high2}, {low3, high3}};
  for (size_t row = 0; row < kRows; ++row) std::memcpy(products[row], sums[row], sizeof(sums[row]));
}

void InnerProducts::Compute(std::span<const float> queries, std::vector<float>* products) const {
  VANTAGE_CHECK(dimension_ > 0 && queries.size() % dimension_ == 0, "queries of the same length");
  const size_t count = queries.size() / dimension_;
  products->resize(count * stride());
  // A block stays in the cache while all queries pass by.
  for (size_t block = 0; block < num_blocks_; ++block) {
    for (size_t first = 0; first < count; first += kRows) {
      const float* rows[kRows];
      float* sums[kRows];
      for (size_t row = 0; row < kRows; ++row) {
        // Past the end the last query is done again.
        const size_t query = std::min(first + row, count - 1);
        rows[row] = queries.data() + query * dimension_;
        sums[row] = products->data() + query * stride() + block * kBlock;
      }
      MultiplyBlock(blocks_.data() + block * kBlock * dimension_, dimension_, rows, sums);
    }
  }
}

}  // namespace vantage
