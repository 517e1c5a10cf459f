#pragma once

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
/// them by reference: by value they have another ABI with and without AVX.
using F8 = float __attribute__((vector_size(32)));
using I8 = int32_t __attribute__((vector_size(32)));

}  // namespace vantage
