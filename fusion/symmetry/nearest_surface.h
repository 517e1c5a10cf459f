#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/triangle_mesh.h"

namespace vantage {

/// Finds the point of a mesh's surface nearest to another: a binary tree of the triangles' boxes,
/// exact but for rounding. Immutable once made; O(log n) a search near the surface.
class NearestSurface {
 public:
  struct Hit {
    Eigen::Vector3d point;   ///< m
    Eigen::Vector3d normal;  ///< unit, of the triangle
    double distance;         ///< m; infinite when there is none
  };

  /// @param mesh of one triangle with area or more; those without are left out.
  explicit NearestSurface(const TriangleMesh& mesh);

  [[nodiscard]] Hit Nearest(const Eigen::Vector3d& point) const;
  /// Not farther than `reach`, m; the nearer, the faster.
  [[nodiscard]] Hit NearestWithin(const Eigen::Vector3d& point, double reach) const;
  /// Of the triangles whose outside lies within 90 degrees of `normal` and not farther than
  /// `reach`, m: the front of a thin sheet is not near its back.
  [[nodiscard]] Hit NearestFacing(const Eigen::Vector3d& point,
                                  const Eigen::Vector3d& normal,
                                  double reach) const;

 private:
  struct Triangle {
    Eigen::Vector3d a, b, c;
  };
  struct Node {
    Eigen::AlignedBox3d box;
    uint32_t begin, end;  // Triangles below it.
    uint32_t children;    // The first of two; 0 for a leaf.
  };

  struct Query {
    Eigen::Vector3d point;
    Eigen::Vector3d facing;  // 0: any triangle.
  };

  void Build(uint32_t node);
  void Search(uint32_t node, const Query& query, double* squared, Hit* hit) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace vantage
