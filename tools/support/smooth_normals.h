#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// Normals for shading a mesh: those of triangles that share a place blend where the surface bends
/// by less than the crease angle, and stay apart across creases.
class SmoothNormals {
 public:
  static constexpr double kCreaseAngle = 40.0 * kDegree;  ///< rad

  /// `mesh` outlives this object.
  explicit SmoothNormals(const TriangleMesh& mesh);

  /// Unit normal at a point of a triangle.
  [[nodiscard]] Eigen::Vector3f At(size_t triangle, const Eigen::Vector3f& p_mesh) const;

 private:
  const TriangleMesh* mesh_;
  std::vector<std::array<Eigen::Vector3f, 3>> corners_;  // Unit normals at a triangle's corners.
};

}  // namespace vantage
