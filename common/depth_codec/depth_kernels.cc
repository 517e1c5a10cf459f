#include "common/depth_codec/depth_kernels.h"

#include <vector>

namespace vantage {

std::span<const DepthKernels> AvailableDepthKernels() {
  static const std::vector<DepthKernels> kAvailable = [] {
    std::vector<DepthKernels> available;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vbmi2") && __builtin_cpu_supports("popcnt")) {
      available.push_back(kAvx512DepthKernels);
    }
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt")) {
      available.push_back(kAvx2DepthKernels);
    }
#endif
    available.push_back(kPortableDepthKernels);
    return available;
  }();
  return kAvailable;
}

}  // namespace vantage
