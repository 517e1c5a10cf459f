#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"

namespace vantage {

/// Triangles over shared vertices, m. Counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;

  [[nodiscard]] Eigen::AlignedBox3f Bounds() const;
  /// Sum of the triangles' areas, m^2.
  [[nodiscard]] double Area() const;
  /// Centroid of the surface (not of the volume), m.
  [[nodiscard]] Eigen::Vector3d SurfaceCentroid() const;
  /// Largest distance between two vertices, m, to within 1 % from below (searched over 500
  /// directions).
  [[nodiscard]] double Diameter() const;
  /// Outward normal of a triangle, not normalised: its length is twice the area.
  [[nodiscard]] Eigen::Vector3f ScaledNormal(size_t triangle) const;
};

/// A point on a surface with its outward unit normal.
struct SurfacePoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< m
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
};

/// `count` points, uniform over the area; a normal is its triangle's.
std::vector<SurfacePoint> SampleSurface(const TriangleMesh& mesh, size_t count, Rng& rng);

/// Joins `part`, moved by `T_mesh_part`, to `mesh`.
void Append(const TriangleMesh& part, const Pose& T_mesh_part, TriangleMesh* mesh);

}  // namespace vantage
