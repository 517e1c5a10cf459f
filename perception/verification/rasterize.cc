#include "perception/verification/rasterize.h"

#include "perception/verification/simd_kernels.h"

namespace vantage {
namespace {

// Pixels this far outside an edge still count, so that none falls between triangles that share it:
// rounding is well below, the difference invisible (1e-4 px).
constexpr float kSlackPerExtent = 1e-6F;
constexpr float kLeastExtent = 32.0F;  // px

namespace baseline {
#include "perception/verification/rasterize.inc"
}  // namespace baseline

#ifdef VANTAGE_HAS_AVX2_PATH
#pragma GCC push_options
#pragma GCC target("avx2")
#define VANTAGE_AVX2_PATH
namespace avx2 {
#include "perception/verification/rasterize.inc"
}  // namespace avx2
#undef VANTAGE_AVX2_PATH
#pragma GCC pop_options
#endif

}  // namespace

SimdPath BestSimdPath() {
#ifdef VANTAGE_HAS_AVX2_PATH
  static const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  if (has_avx2) return SimdPath::kAvx2;
#endif
  return SimdPath::kBaseline;
}

PixelWindow Rasterize(const RasterJob& job, SimdPath path) {
#ifdef VANTAGE_HAS_AVX2_PATH
  if (path == SimdPath::kAvx2) return avx2::Draw(job);
#endif
  return baseline::Draw(job);
}

}  // namespace vantage
