#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/symmetry_group.h"
#include "fusion/orientation_filter.h"
#include "fusion/orientation_fusion.h"
#include "fusion/so3_grid.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// Makes a method anew for a sequence.
/// @param seed of methods that draw random numbers. @param symmetry of the object, for methods that
/// are told it.
using FusionMaker =
    std::function<std::unique_ptr<OrientationFusion>(uint64_t seed, const SymmetryGroup& symmetry)>;

/// A way to fuse orientations.
struct FusionMethod {
  MethodInfo info;
  bool is_slow = false;  ///< takes more than about 1 ms a view: its outcomes are worth keeping
  FusionMaker make;
};

/// A parameter that a method is tuned by.
struct MethodParameter {
  std::string name;                ///< "sigma"
  std::string unit;                ///< "deg"; empty where it has none
  double value = 0.0;              ///< that the evaluation has
  std::vector<double> candidates;  ///< that tuning tries, ascending; `value` is one of them
};

/// A method of which parameters can be tried.
struct TunableMethod {
  MethodInfo info;  ///< its `parameters` are those that are not tuned
  bool is_slow = false;
  std::vector<MethodParameter> parameters;
  /// @param values of `parameters`, in their order and units.
  std::function<FusionMaker(const std::vector<double>& values)> make;

  [[nodiscard]] std::vector<double> Values() const;
  /// The method with other values, which its info tells.
  [[nodiscard]] FusionMethod With(const std::vector<double>& values) const;
};

/// All methods of the paper's Table 2 and Fig. 10 in their order there, then those past it. Each
/// with the values that served it best on sequences of another seed (docs/evaluation.md).
/// @param grid outlives the methods.
std::vector<TunableMethod> TunableMethods(const So3Grid& grid);
std::vector<FusionMethod> FusionMethods(const So3Grid& grid);

/// Those of the confidence and verification weighted clustering among them.
OrientationFilterParameters ClusteringParameters();

inline constexpr const char* kParticleFilterId = "particle_filter";
/// The variant of ours that the others are compared with, and the same without the symmetry group.
inline constexpr const char* kBestOursId = "density_mode_symmetry";
inline constexpr const char* kBestBlindId = "density_mode";

}  // namespace vantage
