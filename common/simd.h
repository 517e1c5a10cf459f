#pragma once

#include <cstddef>
#include <cstdint>

/// Before a function's definition: it is compiled twice, once for AVX2, and the loader picks what
/// the processor has. Without fused multiply-add, so that both give the same results to the bit.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VANTAGE_SIMD __attribute__((target_clones("avx2", "default")))
#else
#define VANTAGE_SIMD
#endif

namespace vantage {

/// Lanes of a vector. Sums run in this many lanes whatever the processor has, so that their order
/// is fixed.
inline constexpr int kLanes = 8;

/// Vectors of GCC's extension: arithmetic, comparison and `mask ? a : b` work lane by lane. Pass
/// them by reference: by value they have another ABI with and without AVX. Never as a template's
/// argument, std::array's for one: it drops their alignment; F8s and structs keep it.
using F8 = float __attribute__((vector_size(32), aligned(32)));
using I8 = int32_t __attribute__((vector_size(32), aligned(32)));

/// An array of N vectors.
template <std::size_t N>
struct alignas(32) F8s {
  F8 vectors[N];

  F8& operator[](std::size_t i) { return vectors[i]; }
  const F8& operator[](std::size_t i) const { return vectors[i]; }
};

/// Rows become columns.
[[gnu::always_inline]] inline void Transpose(F8s<kLanes>* rows) {
  F8s<kLanes>& r = *rows;
  F8s<kLanes> pairs;
  F8s<kLanes> quads;
  for (std::size_t i = 0; i < kLanes; i += 2) {
    pairs[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    pairs[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (std::size_t i = 0; i < kLanes; i += 4) {
    for (std::size_t j = 0; j < 2; ++j) {
      const F8& a = pairs[i + j];
      const F8& b = pairs[i + j + 2];
      quads[i + 2 * j] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
      quads[i + 2 * j + 1] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    r[i] = __builtin_shufflevector(quads[i], quads[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    r[i + 4] = __builtin_shufflevector(quads[i], quads[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

}  // namespace vantage
