#pragma once

namespace vantage {

/// Instructions with which images of hypotheses are drawn and compared; the results are the same to
/// the bit. Kernels are compiled once for each, from the same text.
enum class SimdPath { kBaseline, kAvx2 };

/// The best that the compiler and the processor know.
SimdPath BestSimdPath();

}  // namespace vantage
