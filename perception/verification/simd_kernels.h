#pragma once

// For files that compile a kernel once for each SimdPath: they include its text twice, the second
// time for AVX2. It uses functions of no other header, so that none is compiled for AVX2 by chance.

#include "common/simd.h"
#include "perception/verification/simd_path.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define VANTAGE_HAS_AVX2_PATH
#include <immintrin.h>
#endif

#define VANTAGE_INLINE [[gnu::always_inline]] inline

// Vectors are passed between functions that are all inlined here: their ABI does not matter.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif
