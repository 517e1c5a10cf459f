#pragma once

#include <string>

#include "common/result.h"
#include "common/symmetry_group.h"

namespace vantage {

/// How a symmetry group is described in model.toml and on the command line: by what made it.
struct SymmetryDescription {
  enum class Kind { kNone, kCyclic, kDihedral, kContinuous, kFinite };
  Kind kind = Kind::kNone;
  int order = 1;                                              ///< cyclic, dihedral
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();            ///< all but none and finite
  Eigen::Vector3d half_turn_axis = Eigen::Vector3d::UnitX();  ///< dihedral
  bool flips = false;                                         ///< continuous
};

/// What a group is: a finite one that is neither cyclic nor dihedral is kFinite.
SymmetryDescription DescribeSymmetry(const SymmetryGroup& group);

/// The group of a description from outside; not for kFinite, which lists its elements. Errors: an
/// order outside 1..1000, axes that are not finite, zero, or not perpendicular within 0.1 rad.
Result<SymmetryGroup> MakeSymmetry(const SymmetryDescription& description);

/// "none", "cyclic:ORDER:AXIS", "dihedral:ORDER:AXIS:HALF_TURN_AXIS", "continuous:AXIS" or
/// "continuous-flip:AXIS", an axis being x, y, z or three numbers as in 0,0.6,0.8.
Result<SymmetryGroup> ParseSymmetry(const std::string& text);

/// For people: "3-fold about (0, 0, 1)".
std::string SymmetryText(const SymmetryGroup& group);

}  // namespace vantage
