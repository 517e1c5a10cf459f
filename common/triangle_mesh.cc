#include "common/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/check.h"

namespace vantage {

Eigen::AlignedBox3f TriangleMesh::Bounds() const {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : vertices) box.extend(vertex);
  return box;
}

Eigen::Vector3f TriangleMesh::ScaledNormal(size_t triangle) const {
  const auto& [a, b, c] = triangles[triangle];
  return (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]);
}

double TriangleMesh::Area() const {
  double area = 0.0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    area += 0.5 * static_cast<double>(ScaledNormal(i).norm());
  }
  return area;
}

Eigen::Vector3d TriangleMesh::SurfaceCentroid() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0.0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    const double area = static_cast<double>(ScaledNormal(i).norm());
    sum += area * (vertices[a] + vertices[b] + vertices[c]).cast<double>() / 3.0;
    total += area;
  }
  VANTAGE_CHECK(total > 0.0, "surface centroid of a mesh without area");
  return sum / total;
}

double TriangleMesh::Diameter() const {
  // Along each direction the farthest pair of vertices; a Fibonacci lattice on the half sphere.
  constexpr int kDirections = 500;
  double largest = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double z = (i + 0.5) / kDirections;
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    const Eigen::Vector3f direction =
        Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z).cast<float>();
    float lowest = std::numeric_limits<float>::max();
    float highest = std::numeric_limits<float>::lowest();
    Eigen::Vector3f low = Eigen::Vector3f::Zero();
    Eigen::Vector3f high = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f& vertex : vertices) {
      const float along = direction.dot(vertex);
      if (along < lowest) {
        lowest = along;
        low = vertex;
      }
      if (along > highest) {
        highest = along;
        high = vertex;
      }
    }
    largest = std::max(largest, static_cast<double>((high - low).norm()));
  }
  return largest;
}

std::vector<SurfacePoint> SampleSurface(const TriangleMesh& mesh, size_t count, Rng& rng) {
  std::vector<double> cumulative(mesh.triangles.size());
  double total = 0.0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    total += static_cast<double>(mesh.ScaledNormal(i).norm());
    cumulative[i] = total;
  }
  VANTAGE_CHECK(total > 0.0, "samples of a mesh without area");
  std::vector<SurfacePoint> points(count);
  for (SurfacePoint& point : points) {
    const double pick = rng.Uniform() * total;
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), pick);
    const auto triangle = static_cast<size_t>(std::min<std::ptrdiff_t>(
        found - cumulative.begin(), static_cast<std::ptrdiff_t>(cumulative.size()) - 1));
    const double root = std::sqrt(rng.Uniform());
    const double along = rng.Uniform();
    const auto& [a, b, c] = mesh.triangles[triangle];
    point.position = static_cast<float>(1.0 - root) * mesh.vertices[a] +
                     static_cast<float>(root * (1.0 - along)) * mesh.vertices[b] +
                     static_cast<float>(root * along) * mesh.vertices[c];
    point.normal = mesh.ScaledNormal(triangle).normalized();
  }
  return points;
}

void Append(const TriangleMesh& part, const Pose& T_mesh_part, TriangleMesh* mesh) {
  const auto offset = static_cast<uint32_t>(mesh->vertices.size());
  for (const Eigen::Vector3f& vertex : part.vertices) {
    mesh->vertices.emplace_back((T_mesh_part * vertex.cast<double>()).cast<float>());
  }
  for (const auto& [a, b, c] : part.triangles) {
    mesh->triangles.push_back({a + offset, b + offset, c + offset});
  }
}

}  // namespace vantage
