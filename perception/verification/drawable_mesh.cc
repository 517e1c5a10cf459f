#include "perception/verification/drawable_mesh.h"

#include <utility>

namespace vantage {

DrawableMesh::DrawableMesh(TriangleMesh mesh) : mesh_(std::move(mesh)) {
  normals_.reserve(mesh_.triangles.size());
  for (size_t i = 0; i < mesh_.triangles.size(); ++i) {
    const Eigen::Vector3f scaled = mesh_.ScaledNormal(i);
    const float length = scaled.norm();
    normals_.push_back(length > 0.0F ? Eigen::Vector3f(scaled / length) : Eigen::Vector3f::Zero());
  }
}

}  // namespace vantage
