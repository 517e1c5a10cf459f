#include "perception/model/implicit_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "common/check.h"

namespace vantage {
namespace {

// Of a ball whose center moves from `a` to `b` while its radius changes evenly.
double DistanceToRoundCone(const Ball& a, const Ball& b, const Eigen::Vector3d& point) {
  const Eigen::Vector3d along = b.center - a.center;
  const double length = along.norm();
  const Eigen::Vector3d from_a = point - a.center;
  const double position = from_a.dot(along) / length;
  const double aside = std::sqrt(std::max(0.0, from_a.squaredNorm() - position * position));
  // The nearest ball's center sees the point at a right angle to the cone's mantle.
  const double sine = (a.radius - b.radius) / length;
  const double nearest =
      std::clamp(position - aside * sine / std::sqrt(1.0 - sine * sine), 0.0, length);
  return (from_a - nearest / length * along).norm() - (a.radius - sine * nearest);
}

// Union of two solids with a fillet where the distances differ by less than `blend`: the smaller
// distance, less a parabola that joins it with a continuous slope.
double SmoothUnion(double a, double b, double blend) {
  const double overlap = blend - std::abs(a - b);
  const double fillet = overlap > 0.0 ? overlap * overlap / (4.0 * blend) : 0.0;
  return std::min(a, b) - fillet;
}

// Samples of a function at the corners of cubes, x fastest.
struct Grid {
  Eigen::Vector3d origin;  // m
  double cell;             // m
  Eigen::Array3i size;     // corners
  std::vector<double> values;

  [[nodiscard]] size_t Index(const Eigen::Array3i& corner) const {
    return static_cast<size_t>((corner.z() * size.y() + corner.y()) * size.x() + corner.x());
  }
  [[nodiscard]] Eigen::Vector3d Place(const Eigen::Array3i& corner) const {
    return origin + cell * corner.matrix().cast<double>();
  }
  template <class Visit>
  void ForEachCorner(Visit visit) const {
    for (int z = 0; z < size.z(); ++z) {
      for (int y = 0; y < size.y(); ++y) {
        for (int x = 0; x < size.x(); ++x) visit(Eigen::Array3i(x, y, z));
      }
    }
  }
};

// Mean of the points where the cell's edges cross the surface. False if none does.
bool MeanCrossing(const Grid& grid, const Eigen::Array3i& cell, Eigen::Vector3d* mean) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int crossings = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Array3i step = Eigen::Vector3i::Unit(axis).array();
    const Eigen::Array3i u = Eigen::Vector3i::Unit((axis + 1) % 3).array();
    const Eigen::Array3i v = Eigen::Vector3i::Unit((axis + 2) % 3).array();
    for (int side = 0; side < 4; ++side) {
      const Eigen::Array3i from = cell + (side & 1) * u + (side >> 1) * v;
      const double a = grid.values[grid.Index(from)];
      const double b = grid.values[grid.Index(from + step)];
      if ((a < 0.0) == (b < 0.0)) continue;
      sum += grid.Place(from) + grid.cell * (a / (a - b)) * step.matrix().cast<double>();
      ++crossings;
    }
  }
  if (crossings > 0) *mean = sum / crossings;
  return crossings > 0;
}

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

// A quadrangle about each grid edge that crosses the surface, of the vertices of the four cells
// there. @param vertex_of the cell at each corner, kNone without one
void AddFaces(const Grid& grid, const std::vector<uint32_t>& vertex_of, TriangleMesh* mesh) {
  grid.ForEachCorner([&](const Eigen::Array3i& corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Array3i next = corner + Eigen::Vector3i::Unit(axis).array();
      if (next[axis] >= grid.size[axis]) continue;
      const bool leaves = grid.values[grid.Index(corner)] < 0.0;
      if (leaves == (grid.values[grid.Index(next)] < 0.0)) continue;
      const Eigen::Array3i u = Eigen::Vector3i::Unit((axis + 1) % 3).array();
      const Eigen::Array3i v = Eigen::Vector3i::Unit((axis + 2) % 3).array();
      // Counter-clockwise seen from the far end of the edge.
      std::array<uint32_t, 4> quad = {vertex_of[grid.Index(corner - u - v)],
                                      vertex_of[grid.Index(corner - v)],
                                      vertex_of[grid.Index(corner)],
                                      vertex_of[grid.Index(corner - u)]};
      if (!leaves) std::swap(quad[1], quad[3]);
      const auto& at = mesh->vertices;
      // Along the shorter diagonal; of equal ones always the same, whatever their last bits are.
      const float one = (at[quad[0]] - at[quad[2]]).squaredNorm();
      const float other = (at[quad[1]] - at[quad[3]]).squaredNorm();
      const size_t first = other < 0.99F * one ? 1 : 0;
      mesh->triangles.push_back({quad[first], quad[first + 1], quad[first + 2]});
      mesh->triangles.push_back({quad[first], quad[first + 2], quad[(first + 3) % 4]});
    }
  });
}

}  // namespace

void ImplicitSolid::AddLimb(std::vector<Ball> balls, double blend) {
  VANTAGE_CHECK(!balls.empty(), "a limb needs a ball");
  for (size_t i = 0; i < balls.size(); ++i) {
    VANTAGE_CHECK(i == 0 || (balls[i].center - balls[i - 1].center).norm() >
                                std::abs(balls[i].radius - balls[i - 1].radius),
                  "a ball of a limb lies inside its neighbor");
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(balls[i].radius + blend);
    bounds_.extend(balls[i].center - reach).extend(balls[i].center + reach);
  }
  parts_.push_back({std::move(balls), blend});
}

void ImplicitSolid::AddEllipsoid(const Pose& T_solid_ellipsoid,
                                 const Eigen::Vector3d& radii,
                                 double blend) {
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(radii.maxCoeff() + blend);
  const Eigen::Vector3d center = T_solid_ellipsoid.translation();
  bounds_.extend(center - reach).extend(center + reach);
  parts_.push_back({Ellipsoid{T_solid_ellipsoid.inverse(), radii}, blend});
}

double ImplicitSolid::DistanceTo(const std::vector<Ball>& balls, const Eigen::Vector3d& point) {
  double distance = (point - balls[0].center).norm() - balls[0].radius;
  for (size_t i = 1; i < balls.size(); ++i) {
    distance = std::min(distance, DistanceToRoundCone(balls[i - 1], balls[i], point));
  }
  return distance;
}

double ImplicitSolid::DistanceTo(const Ellipsoid& ellipsoid, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = ellipsoid.T_ellipsoid_solid * point;
  const Eigen::Vector3d unit = p.cwiseQuotient(ellipsoid.radii);
  const double radius = unit.norm();
  const double slope = unit.cwiseQuotient(ellipsoid.radii).norm() / std::max(radius, 1e-9);
  // At the very center any direction will do.
  return (radius - 1.0) / std::max(slope, 1.0 / ellipsoid.radii.maxCoeff());
}

double ImplicitSolid::Distance(const Eigen::Vector3d& point) const {
  double distance = std::numeric_limits<double>::infinity();
  for (const Part& part : parts_) {
    const double to_part =
        std::visit([&point](const auto& shape) { return DistanceTo(shape, point); }, part.shape);
    distance = SmoothUnion(distance, to_part, part.blend);
  }
  return std::max(distance, -point.z());
}

Eigen::Vector3d ImplicitSolid::Gradient(const Eigen::Vector3d& point) const {
  constexpr double kStep = 1e-5;  // m
  Eigen::Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
    gradient[axis] = (Distance(point + step) - Distance(point - step)) / (2.0 * kStep);
  }
  return gradient;
}

TriangleMesh ImplicitSolid::Polygonize(double cell) const {
  VANTAGE_CHECK(!parts_.empty(), "nothing to polygonize");
  // The planes y = 0 and z = 0 halve cells: what is symmetric about y = 0 stays so, and no corner
  // lies on the ground.
  Grid grid;
  grid.cell = cell;
  grid.origin = cell * (((bounds_.min() / cell).array().floor() - 1.5).matrix());
  grid.origin.z() = -1.5 * cell;
  grid.size = ((bounds_.max() - grid.origin) / cell).array().ceil().cast<int>() + 2;
  grid.values.resize(static_cast<size_t>(grid.size.prod()));
  grid.ForEachCorner([&](const Eigen::Array3i& corner) {
    grid.values[grid.Index(corner)] = Distance(grid.Place(corner));
  });

  TriangleMesh mesh;
  std::vector<uint32_t> vertex_of(grid.values.size(), kNone);
  grid.ForEachCorner([&](const Eigen::Array3i& corner) {
    Eigen::Vector3d vertex;
    if ((corner + 1 >= grid.size).any() || !MeanCrossing(grid, corner, &vertex)) return;
    const Eigen::Vector3d low = grid.Place(corner);
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d gradient = Gradient(vertex);
      vertex -= Distance(vertex) / std::max(gradient.squaredNorm(), 0.01) * gradient;
      vertex = vertex.cwiseMax(low).cwiseMin(low + Eigen::Vector3d::Constant(cell));
    }
    vertex_of[grid.Index(corner)] = static_cast<uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(vertex.cwiseMax(Eigen::Vector3d(-1e9, -1e9, 0.0)).cast<float>());
  });
  AddFaces(grid, vertex_of, &mesh);
  return mesh;
}

}  // namespace vantage
