#include "perception/verification/mesh_decimation.h"

#include <meshoptimizer.h>

#include <vector>

#include "perception/verification/mesh_topology.h"

namespace vantage {

TriangleMesh DecimateMesh(const TriangleMesh& mesh, size_t max_triangles, double max_error) {
  TriangleMesh welded = WeldVertices(mesh);
  if (welded.triangles.size() <= max_triangles || !(max_error > 0.0)) return welded;
  const float* vertices = welded.vertices.front().data();
  const size_t num_vertices = welded.vertices.size();
  constexpr size_t kStride = sizeof(Eigen::Vector3f);
  const auto scale = static_cast<double>(meshopt_simplifyScale(vertices, num_vertices, kStride));
  TriangleMesh fewer;
  fewer.triangles.resize(welded.triangles.size());
  const size_t size = meshopt_simplify(fewer.triangles.front().data(),
                                       welded.triangles.front().data(),
                                       3 * welded.triangles.size(),
                                       vertices,
                                       num_vertices,
                                       kStride,
                                       3 * max_triangles,
                                       static_cast<float>(max_error / scale),
                                       0,
                                       nullptr);
  fewer.triangles.resize(size / 3);
  fewer.vertices = std::move(welded.vertices);
  return WeldVertices(fewer);  // Drops unused vertices.
}

TriangleMesh DecimateMesh(const TriangleMesh& mesh, const LevelOfDetail& level) {
  return DecimateMesh(mesh, level.max_triangles, level.max_error * mesh.Diameter());
}

}  // namespace vantage
