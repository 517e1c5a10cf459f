#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/rng.h"

namespace vantage {

/// Spatially correlated standard normal noise for many frames: a periodic field made once, of which
/// every frame takes the sum of two windows at random places, so that fields of different frames
/// are in effect independent at the cost of two reads a pixel.
class NoiseTile {
 public:
  static constexpr uint32_t kWidth = 1024;  ///< px, a power of two
  static constexpr uint32_t kHeight = 512;  ///< px, a power of two

  /// @param correlation px, sigma of the Gaussian that smooths white noise; 0: white.
  NoiseTile(double correlation, uint64_t seed);

  /// One frame's field over the image plane, repeating after kWidth and kHeight px.
  class Window {
   public:
    Window(const NoiseTile& tile, Rng& rng);
    /// The value at a pixel, u and v >= 0.
    [[nodiscard]] float at(int u, int v) const {
      const auto x = static_cast<uint32_t>(u);
      const auto y = static_cast<uint32_t>(v);
      return kHalf * (values_[Index(x + u1_, y + v1_)] + values_[Index(x + u2_, y + v2_)]);
    }

    /// Row v of the field, from u on.
    void Row(int u, int v, std::span<float> row) const;

   private:
    static size_t Index(uint32_t u, uint32_t v) {
      return static_cast<size_t>((v & (kHeight - 1)) * kWidth + (u & (kWidth - 1)));
    }
    static constexpr float kHalf = 0.70710678F;  // sqrt(1/2): the sum has unit variance again.

    const float* values_;
    uint32_t u1_, v1_, u2_, v2_;
  };

 private:
  std::vector<float> values_;
};

}  // namespace vantage
