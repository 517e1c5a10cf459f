#include "perception/verification/compare.h"

#include "perception/verification/simd_kernels.h"

namespace vantage {
namespace {

namespace baseline {
#include "perception/verification/compare.inc"
}  // namespace baseline

#ifdef VANTAGE_HAS_AVX2_PATH
#pragma GCC push_options
#pragma GCC target("avx2")
#define VANTAGE_AVX2_PATH
namespace avx2 {
#include "perception/verification/compare.inc"
}  // namespace avx2
#undef VANTAGE_AVX2_PATH
#pragma GCC pop_options
#endif

}  // namespace

Compared Compare(const CompareJob& job, double cost, SimdPath path) {
#ifdef VANTAGE_HAS_AVX2_PATH
  if (path == SimdPath::kAvx2) return avx2::CompareRows(job, cost);
#endif
  return baseline::CompareRows(job, cost);
}

}  // namespace vantage
