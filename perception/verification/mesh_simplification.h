#pragma once

#include "common/triangle_mesh.h"

namespace vantage {

/// Joins the vertices in each cube of side `cell` (m) at their mean and drops the triangles that
/// collapse (Rossignac, Borrel 1993): quicker to draw, off by a fraction of the cell.
TriangleMesh SimplifyMesh(const TriangleMesh& mesh, double cell);

}  // namespace vantage
