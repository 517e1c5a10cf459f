#pragma once

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <string>
#include <system_error>
#include <vector>

#include "common/check.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// A folder of a test's own, gone when the test is over.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "vantage-test.XXXXXX").string();
    VANTAGE_CHECK(::mkdtemp(name.data()) != nullptr, name);
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Files and folders directly in it.
  [[nodiscard]] std::ptrdiff_t CountEntries() const {
    return std::distance(std::filesystem::directory_iterator(path_),
                         std::filesystem::directory_iterator());
  }

 private:
  std::filesystem::path path_;
};

/// Distance of a point to a triangle (a, b, c): to its plane if it projects inside, else to the
/// nearest of its edges.
inline double DistanceToTriangle(const Eigen::Vector3d& p,
                                 const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
  const auto inside = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return (to - from).cross(p - from).dot(normal) >= 0.0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs((p - a).dot(normal));
  const auto to_edge = [&p](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const double along =
        std::clamp((p - from).dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
    return (p - from - along * (to - from)).norm();
  };
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

/// Distance of points to the nearest triangle of a mesh, by trying all of them.
class MeshDistance {
 public:
  explicit MeshDistance(const TriangleMesh& mesh) {
    for (const auto& [a, b, c] : mesh.triangles) {
      Triangle triangle;
      triangle.corners = {mesh.vertices[a].cast<double>(),
                          mesh.vertices[b].cast<double>(),
                          mesh.vertices[c].cast<double>()};
      triangle.middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3.0;
      for (const Eigen::Vector3d& corner : triangle.corners) {
        triangle.radius = std::max(triangle.radius, (corner - triangle.middle).norm());
      }
      triangles_.push_back(triangle);
    }
  }

  [[nodiscard]] double To(const Eigen::Vector3d& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Triangle& triangle : triangles_) {
      // The sphere that holds the triangle tells most of them apart cheaply.
      if ((p - triangle.middle).norm() - triangle.radius > nearest) continue;
      const auto& [a, b, c] = triangle.corners;
      nearest = std::min(nearest, DistanceToTriangle(p, a, b, c));
    }
    return nearest;
  }

 private:
  struct Triangle {
    std::array<Eigen::Vector3d, 3> corners;
    Eigen::Vector3d middle;
    double radius = 0.0;
  };
  std::vector<Triangle> triangles_;
};

}  // namespace vantage
