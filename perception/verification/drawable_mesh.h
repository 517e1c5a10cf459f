#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/triangle_mesh.h"

namespace vantage {

/// A mesh as ModelView draws it.
class DrawableMesh {
 public:
  explicit DrawableMesh(TriangleMesh mesh);

  [[nodiscard]] size_t num_triangles() const { return mesh_.triangles.size(); }
  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  /// Outward unit normal of a triangle; 0 where it has no area.
  [[nodiscard]] const Eigen::Vector3f& normal(size_t triangle) const { return normals_[triangle]; }

 private:
  TriangleMesh mesh_;
  std::vector<Eigen::Vector3f> normals_;
};

}  // namespace vantage
