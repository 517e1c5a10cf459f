#pragma once

#include <cstddef>

#include "common/result.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// What CheckAndMendMesh did to a mesh, and found.
struct MeshMending {
  size_t merged_vertices = 0;    ///< Vertices that were at another one's place.
  size_t removed_triangles = 0;  ///< Triangles with two corners in one place.
  size_t open_edges = 0;         ///< Edges of one triangle only; 0: the mesh is closed.
  size_t odd_edges = 0;          ///< Edges of three or more triangles, or of two that disagree.
  bool flipped = false;          ///< It was closed but for a few edges, and inside out.
};

inline constexpr double kSmallestDiameter = 0.005;  ///< m
inline constexpr double kLargestDiameter = 5.0;     ///< m

/// Makes a mesh from outside fit for use: merges vertices in the same place, leaves out triangles
/// without corners of their own and vertices without triangles, and turns a mesh that is inside out
/// (closed, or open at less than 5 % of its edges). Errors name why a mesh is refused: empty,
/// indices out of range, coordinates not finite, no area, flat, or a diameter outside 5 mm to 5 m
/// (then the unit is probably wrong).
Result<MeshMending> CheckAndMendMesh(TriangleMesh* mesh);

/// Volume enclosed by a closed mesh, m^3; negative when it is inside out.
double SignedVolume(const TriangleMesh& mesh);

}  // namespace vantage
