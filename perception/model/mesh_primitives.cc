#include "perception/model/mesh_primitives.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/check.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Vector3d MeanOf(const Ring& ring) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : ring) sum += point;
  return sum / static_cast<double>(ring.size());
}

uint32_t AddVertex(const Eigen::Vector3d& vertex, TriangleMesh* mesh) {
  mesh->vertices.push_back(vertex.cast<float>());
  return static_cast<uint32_t>(mesh->vertices.size() - 1);
}

double SignedPower(double value, double exponent) {
  return std::copysign(std::pow(std::abs(value), exponent), value);
}

}  // namespace

TriangleMesh Loft(std::span<const Ring> rings) {
  VANTAGE_CHECK(rings.size() >= 2 && rings.front().size() >= 3, "a loft needs two rings");
  const auto points = static_cast<uint32_t>(rings.front().size());
  TriangleMesh mesh;
  for (const Ring& ring : rings) {
    VANTAGE_CHECK(ring.size() == points, "rings of a loft differ in size");
    for (const Eigen::Vector3d& point : ring) AddVertex(point, &mesh);
  }
  const auto at = [points](uint32_t ring, uint32_t point) {
    return ring * points + point % points;
  };
  const auto last = static_cast<uint32_t>(rings.size() - 1);
  for (uint32_t i = 0; i < last; ++i) {
    for (uint32_t j = 0; j < points; ++j) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  const uint32_t bottom = AddVertex(MeanOf(rings.front()), &mesh);
  const uint32_t top = AddVertex(MeanOf(rings.back()), &mesh);
  for (uint32_t j = 0; j < points; ++j) {
    mesh.triangles.push_back({bottom, at(0, j + 1), at(0, j)});
    mesh.triangles.push_back({top, at(last, j), at(last, j + 1)});
  }
  return mesh;
}

TriangleMesh Revolve(std::span<const Eigen::Vector2d> profile, int segments) {
  VANTAGE_CHECK(profile.size() >= 4, "a profile needs two points off the axis");
  std::vector<Ring> rings;
  for (const Eigen::Vector2d& point : profile.subspan(1, profile.size() - 2)) {
    rings.push_back(PolarRing([&point](double) { return point.x(); }, point.y(), segments));
  }
  TriangleMesh mesh = Loft(rings);
  // The fans' middles are the profile's ends, which may lie higher or lower than the rings.
  mesh.vertices[mesh.vertices.size() - 2].z() = static_cast<float>(profile.front().y());
  mesh.vertices[mesh.vertices.size() - 1].z() = static_cast<float>(profile.back().y());
  return mesh;
}

Ring SuperellipseRing(double a, double b, double exponent, double z, int points) {
  Ring ring;
  for (int i = 0; i < points; ++i) {
    const double angle = 2.0 * kPi * i / points;
    ring.emplace_back(a * SignedPower(std::cos(angle), 2.0 / exponent),
                      b * SignedPower(std::sin(angle), 2.0 / exponent),
                      z);
  }
  return ring;
}

Ring RoundedRectangleRing(double x, double y, double radius, double z, int points_per_corner) {
  Ring ring;
  for (int corner = 0; corner < 4; ++corner) {
    const double sign_x = corner == 0 || corner == 3 ? 1.0 : -1.0;
    const double sign_y = corner < 2 ? 1.0 : -1.0;
    for (int i = 0; i < points_per_corner; ++i) {
      const double angle = 0.5 * kPi * (corner + i / std::max(1.0, points_per_corner - 1.0));
      ring.emplace_back(sign_x * (0.5 * x - radius) + radius * std::cos(angle),
                        sign_y * (0.5 * y - radius) + radius * std::sin(angle),
                        z);
    }
  }
  return ring;
}

TriangleMesh Cylinder(double radius, double z0, double z1, double bevel, int segments) {
  const std::array<Eigen::Vector2d, 6> profile = {Eigen::Vector2d(0.0, z0),
                                                  Eigen::Vector2d(radius - bevel, z0),
                                                  Eigen::Vector2d(radius, z0 + bevel),
                                                  Eigen::Vector2d(radius, z1 - bevel),
                                                  Eigen::Vector2d(radius - bevel, z1),
                                                  Eigen::Vector2d(0.0, z1)};
  return Revolve(profile, segments);
}

TriangleMesh BeveledBox(const Eigen::Vector3d& size, double bevel) {
  const auto ring = [&size, bevel](double inset, double z) {
    // Two points a corner: a beveled corner, whose length is kept when the ring is inset.
    return RoundedRectangleRing(size.x() - 2.0 * inset, size.y() - 2.0 * inset, bevel, z, 2);
  };
  const std::array<Ring, 4> rings = {
      ring(bevel, 0.0), ring(0.0, bevel), ring(0.0, size.z() - bevel), ring(bevel, size.z())};
  return Loft(rings);
}

TriangleMesh Ellipsoid(const Eigen::Vector3d& radii, int segments) {
  std::vector<Eigen::Vector2d> profile = {{0.0, -1.0}};
  for (int i = 1; i < segments / 2; ++i) {
    const double latitude = kPi * (2.0 * i / segments - 0.5);
    profile.emplace_back(std::cos(latitude), std::sin(latitude));
  }
  profile.emplace_back(0.0, 1.0);
  TriangleMesh mesh = Revolve(profile, segments);
  for (Eigen::Vector3f& vertex : mesh.vertices) {
    vertex = vertex.cwiseProduct(radii.cast<float>());
  }
  return mesh;
}

TriangleMesh Rod(std::span<const Eigen::Vector3d> path,
                 const Eigen::Vector3d& plane_normal,
                 double radius,
                 int segments) {
  VANTAGE_CHECK(path.size() >= 2, "a rod needs two points");
  const Eigen::Vector3d across = plane_normal.normalized();
  std::vector<Ring> rings;
  for (size_t i = 0; i < path.size(); ++i) {
    const Eigen::Vector3d& before = path[i == 0 ? 0 : i - 1];
    const Eigen::Vector3d& after = path[std::min(i + 1, path.size() - 1)];
    const Eigen::Vector3d along = (after - before).normalized();
    // (across, along x across, along) is right-handed: the ring goes counter-clockwise.
    const Eigen::Vector3d aside = along.cross(across);
    Ring ring;
    for (int j = 0; j < segments; ++j) {
      const double angle = 2.0 * kPi * j / segments;
      ring.emplace_back(path[i] + radius * (std::cos(angle) * across + std::sin(angle) * aside));
    }
    rings.push_back(std::move(ring));
  }
  return Loft(rings);
}

TriangleMesh Wedge(double length, double height, double width) {
  const double y = 0.5 * width;
  // Seen from +y towards -y, counter-clockwise is x towards -z: hence this order.
  const auto ring = [length, height](double at) {
    return Ring{{0.0, at, 0.0}, {0.0, at, height}, {length, at, 0.0}};
  };
  const std::array<Ring, 2> rings = {ring(-y), ring(y)};
  return Loft(rings);
}

}  // namespace vantage
