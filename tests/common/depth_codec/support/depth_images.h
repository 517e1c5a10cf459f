#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/rng.h"

namespace vantage {

struct TestDepth {
  std::string name;
  int width = 0;   ///< px
  int height = 0;  ///< px
  std::vector<uint16_t> depth;
};

/// A slanted table with boxes as a structured-light camera gives it: depth in steps of its
/// disparity, noise of `sigma` steps, shadows, single pixels lost. mm
TestDepth StructuredLightDepth(int width, int height, double sigma, Rng& rng);

/// Images that are hard in one way or another, small ones.
std::vector<TestDepth> AdversarialDepths(Rng& rng);

}  // namespace vantage
