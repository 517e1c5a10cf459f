#include "tools/support/smooth_normals.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace vantage {
namespace {

using Place = std::tuple<float, float, float>;

Place PlaceOf(const Eigen::Vector3f& vertex) { return {vertex.x(), vertex.y(), vertex.z()}; }

Eigen::Vector3f UnitOr(const Eigen::Vector3f& vector, const Eigen::Vector3f& otherwise) {
  const float length = vector.norm();
  return length > 0.0F ? Eigen::Vector3f(vector / length) : otherwise;
}

}  // namespace

SmoothNormals::SmoothNormals(const TriangleMesh& mesh) : mesh_(&mesh) {
  std::vector<Eigen::Vector3f> scaled(mesh.triangles.size());
  std::vector<Eigen::Vector3f> unit(mesh.triangles.size());
  std::map<Place, std::vector<size_t>> around;  // Vertices may be stored once per triangle.
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    scaled[t] = mesh.ScaledNormal(t);
    unit[t] = UnitOr(scaled[t], Eigen::Vector3f::UnitZ());
    for (const uint32_t vertex : mesh.triangles[t]) {
      around[PlaceOf(mesh.vertices[vertex])].push_back(t);
    }
  }
  const auto least_cosine = static_cast<float>(std::cos(kCreaseAngle));
  corners_.resize(mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (size_t corner = 0; corner < 3; ++corner) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const size_t other : around[PlaceOf(mesh.vertices[mesh.triangles[t][corner]])]) {
        if (unit[other].dot(unit[t]) > least_cosine) sum += scaled[other];
      }
      corners_[t][corner] = UnitOr(sum, unit[t]);
    }
  }
}

Eigen::Vector3f SmoothNormals::At(size_t triangle, const Eigen::Vector3f& p_mesh) const {
  const auto& [ia, ib, ic] = mesh_->triangles[triangle];
  const Eigen::Vector3f& a = mesh_->vertices[ia];
  const Eigen::Vector3f& b = mesh_->vertices[ib];
  const Eigen::Vector3f& c = mesh_->vertices[ic];
  const Eigen::Vector3f normal = (b - a).cross(c - a);
  const float area2 = normal.squaredNorm();
  const std::array<Eigen::Vector3f, 3>& corner = corners_[triangle];
  if (!(area2 > 0.0F)) return corner[0];
  const float share_b = std::clamp((p_mesh - a).cross(c - a).dot(normal) / area2, 0.0F, 1.0F);
  const float share_c = std::clamp((b - a).cross(p_mesh - a).dot(normal) / area2, 0.0F, 1.0F);
  const float share_a = std::max(0.0F, 1.0F - share_b - share_c);
  return UnitOr(share_a * corner[0] + share_b * corner[1] + share_c * corner[2], corner[0]);
}

}  // namespace vantage
