#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/depth_payload.h"

namespace vantage {

/// Two rows of a band, the one in hand and the one above it.
class DepthRows {
 public:
  /// Begins a band: above its first row nothing is measured and all ranks are 0.
  void Reset(size_t columns) {
    columns_ = columns;
    for (size_t i = 0; i < 2; ++i) {
      ranks_[i].assign(DepthLayout::kStrips * (columns + 2), 0);
      valid_[i].assign(columns + 2, 0);
    }
  }

  DepthRowView row() { return {ranks_[now_].data(), valid_[now_].data()}; }
  DepthRowView above() { return {ranks_[1 - now_].data(), valid_[1 - now_].data()}; }

  /// The row in hand is complete and becomes the one above.
  void Advance() {
    constexpr size_t kStrips = DepthLayout::kStrips;
    uint16_t* ranks = ranks_[now_].data();
    uint32_t* valid = valid_[now_].data();
    uint16_t* after = ranks + kStrips * (columns_ + 1);
    std::memcpy(ranks + 1, after - kStrips, 2 * (kStrips - 1));
    std::memcpy(after, ranks + kStrips + 1, 2 * (kStrips - 1));
    valid[0] = valid[columns_] << 1U;
    valid[columns_ + 1] = valid[1] >> 1U;
    now_ = 1 - now_;
  }

 private:
  size_t columns_ = 0;
  size_t now_ = 0;
  std::vector<uint16_t> ranks_[2];
  std::vector<uint32_t> valid_[2];
};

}  // namespace vantage
