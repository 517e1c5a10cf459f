#pragma once

#include "common/triangle_mesh.h"

namespace vantage {

/// The mesh with vertices of equal position joined, without triangles that are not finite, name a
/// vertex that is not there, or have no area; unused vertices are dropped.
TriangleMesh WeldVertices(const TriangleMesh& mesh);

/// True when every edge is passed as often in one sense as in the other, and every connected part
/// encloses a positive volume.
/// @param mesh welded.
bool IsClosed(const TriangleMesh& mesh);

}  // namespace vantage
