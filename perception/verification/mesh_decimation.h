#pragma once

#include <cstddef>

#include "common/triangle_mesh.h"

namespace vantage {

/// Fewer triangles for the same surface by collapsing edges, least quadric error first (Garland,
/// Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997; meshoptimizer's). Open and
/// non-manifold meshes keep their borders; a mesh of no more than `max_triangles` comes back
/// welded. The result may have more than `max_triangles` where `max_error` or the mesh's topology
/// forbids to go on.
/// @param max_error m, by which the surface may move.
TriangleMesh DecimateMesh(const TriangleMesh& mesh, size_t max_triangles, double max_error);

/// Triangles and error of a mesh at a level of detail.
struct LevelOfDetail {
  size_t max_triangles;
  double max_error;  ///< of the mesh's diameter
};
inline constexpr LevelOfDetail kCoarseLevel{500, 0.03};  ///< to rank hypotheses at every 4th pixel
inline constexpr LevelOfDetail kFineLevel{5000, 0.004};  ///< to refine and decide
TriangleMesh DecimateMesh(const TriangleMesh& mesh, const LevelOfDetail& level);

}  // namespace vantage
