#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/symmetry_group.h"
#include "fusion/orientation_fusion.h"
#include "fusion/so3_grid.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// A way to fuse orientations that can be made anew for every sequence.
struct FusionMethod {
  MethodInfo info;
  /// @param seed of methods that draw random numbers. @param symmetry of the object, for methods
  /// that are told it.
  std::function<std::unique_ptr<OrientationFusion>(uint64_t seed, const SymmetryGroup& symmetry)>
      make;
};

/// All methods of the paper's Table 2 and Fig. 10 in their order there, then those past it. Each
/// with the parameters that served it best on sequences of another seed (docs/evaluation.md).
/// @param grid outlives the methods.
std::vector<FusionMethod> FusionMethods(const So3Grid& grid);

inline constexpr const char* kParticleFilterId = "particle_filter";
/// The variant of ours that the others are compared with, and the same without the symmetry group.
inline constexpr const char* kBestOursId = "density_mode_symmetry";
inline constexpr const char* kBestBlindId = "density_mode";

}  // namespace vantage
