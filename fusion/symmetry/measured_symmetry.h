#pragma once

#include <cstdint>

#include "common/result.h"
#include "common/triangle_mesh.h"
#include "fusion/symmetry/found_symmetry.h"

namespace vantage {

struct MeasuredSymmetryParameters {
  int k = 8;              ///< of the grid of rotations that are tried, 2..16
  int num_samples = 600;  ///< points of the surface that are moved, 50..100000
  /// Root mean square distance, in diameters, up to which a rotation of an uneven scan is a
  /// symmetry; in (0, 0.1]. Cartons, cans and cups scanned by turntable stay below 0.0131, bosses
  /// and thumb rests of 12 mm on objects of 0.2 m are above 0.024.
  double tolerance = 0.014;
  /// The same for a mesh without unevenness, in (0, tolerance].
  double least_tolerance = 0.003;
  /// A mesh that its best rotation maps onto itself to within d is uneven by d: others are
  /// symmetries up to this many times d, within the two bounds above; 1 or more.
  double unevenness_factor = 6.0;
  uint64_t seed = 1;  ///< of the samples

  [[nodiscard]] Result<void> Validate() const;
};

/// The rotations that map a mesh onto itself, from the mesh alone (paper 6.3, eq. 14): the object
/// is turned by each representative orientation of the grid, the minima of the error are registered
/// with a small translation, and those within the tolerance completed to a group about a common
/// center. The error of a rotation is the mean squared distance about that center, plus the squared
/// distance by which the surface's centroid moves, since a model's axes pass through the centroid:
/// what stands out on one side breaks a symmetry by both. Confidences are weights of eq. 14 with
/// sigma_mse so that they are 0.5 at the tolerance.
/// Errors: parameters; a mesh that is empty or has indices out of range, no area or coordinates
/// that are not finite. A sphere is a result.
Result<FoundSymmetry> MeasureSymmetry(const TriangleMesh& mesh,
                                      const MeasuredSymmetryParameters& parameters = {});

}  // namespace vantage
