#pragma once

#include <cstdint>

#include "common/result.h"
#include "common/symmetry_group.h"
#include "common/triangle_mesh.h"

namespace vantage {

struct MeasuredSymmetryParameters {
  int k = 8;              ///< of the grid of rotations that are tried, 2..16
  int num_samples = 500;  ///< points of the surface that are rotated, 50..100000
  /// Root mean square distance of the rotated surface to the surface, in diameters of the object,
  /// up to which a rotation is a symmetry; in (0, 0.1].
  double tolerance = 0.003;
  uint64_t seed = 1;  ///< of the samples

  [[nodiscard]] Result<void> Validate() const;
};

/// The rotations about the centroid of its surface that map a mesh onto itself, from the mesh alone
/// (paper 6.3, by mean squared error): the object is turned by each representative orientation of
/// the grid, the minima of the error are refined, and those within the tolerance completed to a
/// group. Distances are from points to triangles, so that sampling adds no error.
/// Errors: parameters; a mesh that is empty or has indices out of range, no area or coordinates
/// that are not finite; a mesh with two axes of continuous symmetry (a ball), for which there is
/// no SymmetryGroup.
Result<SymmetryGroup> MeasureSymmetry(const TriangleMesh& mesh,
                                      const MeasuredSymmetryParameters& parameters = {});

}  // namespace vantage
