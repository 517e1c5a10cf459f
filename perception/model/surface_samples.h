#pragma once

#include <array>
#include <vector>

#include "common/result.h"
#include "common/rng.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

struct SurfaceSampleParameters {
  double spacing = 0.05;           ///< of the diameter; least distance between two samples.
  double crease = 30.0 * kDegree;  ///< rad; faces that meet at a larger angle meet at an edge.
  int directions = 120;            ///< from which the surface is looked at
  int image_size = 256;            ///< px, of each of these looks

  /// Spacing in [0.005, 0.5], crease in [0, pi/2], directions in 1..2000, image size in 32..2048.
  Result<void> Validate() const;
};

/// Samples of the surface that can be seen from outside, none nearer to another one on the same
/// side of the body than the spacing, and no room left for more (dart throwing after Cook 1986).
/// Inner walls, which a camera never sees, get no samples; a surface that is seen only from its
/// back has its normal turned. Normals follow smooth surfaces (mean of the faces about a vertex,
/// weighted by area) and keep creases. The same mesh, parameters and generator give the same
/// samples, and another order of triangles gives others.
/// @param diameter m, of the mesh.
std::vector<SurfacePoint> SampleVisibleSurface(const TriangleMesh& mesh,
                                               double diameter,
                                               const SurfaceSampleParameters& parameters,
                                               Rng& rng);

/// Unit normals at each corner of each triangle: the area-weighted mean over those faces about the
/// vertex that are within `crease` (rad) of the corner's own.
std::vector<std::array<Eigen::Vector3f, 3>> CornerNormals(const TriangleMesh& mesh, double crease);

}  // namespace vantage
