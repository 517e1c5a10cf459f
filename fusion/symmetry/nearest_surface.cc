#include "fusion/symmetry/nearest_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "common/check.h"

namespace vantage {
namespace {

Eigen::Vector3d NearestOnSegment(const Eigen::Vector3d& point,
                                 const Eigen::Vector3d& from,
                                 const Eigen::Vector3d& to) {
  const Eigen::Vector3d along = to - from;
  const double squared = along.squaredNorm();
  if (squared <= 0.0) return from;
  return from + std::clamp((point - from).dot(along) / squared, 0.0, 1.0) * along;
}

// The foot of the perpendicular where it lies inside, else the nearest point of the three edges.
Eigen::Vector3d NearestOnTriangle(const Eigen::Vector3d& point,
                                  const Eigen::Vector3d& a,
                                  const Eigen::Vector3d& b,
                                  const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const std::array<const Eigen::Vector3d*, 3> corners = {&a, &b, &c};
  bool inside = true;
  for (size_t i = 0; i < 3 && inside; ++i) {
    const Eigen::Vector3d& from = *corners[i];
    inside = (*corners[(i + 1) % 3] - from).cross(point - from).dot(normal) >= 0.0;
  }
  if (inside) return point - (point - a).dot(normal) / normal.squaredNorm() * normal;
  Eigen::Vector3d best = NearestOnSegment(point, a, b);
  for (const Eigen::Vector3d& other :
       {NearestOnSegment(point, b, c), NearestOnSegment(point, c, a)}) {
    if ((other - point).squaredNorm() < (best - point).squaredNorm()) best = other;
  }
  return best;
}

}  // namespace

NearestSurface::NearestSurface(const TriangleMesh& mesh) {
  for (const auto& [a, b, c] : mesh.triangles) {
    const Triangle triangle{mesh.vertices[a].cast<double>(),
                            mesh.vertices[b].cast<double>(),
                            mesh.vertices[c].cast<double>()};
    const Eigen::Vector3d normal = (triangle.b - triangle.a).cross(triangle.c - triangle.a);
    if (normal.squaredNorm() > 0.0) triangles_.push_back(triangle);
  }
  VANTAGE_CHECK(!triangles_.empty(), "the nearest point of a mesh without area");
  nodes_.push_back({{}, 0, static_cast<uint32_t>(triangles_.size()), 0});
  Build(0);
}

void NearestSurface::Build(uint32_t node) {
  const uint32_t begin = nodes_[node].begin;
  const uint32_t end = nodes_[node].end;
  Eigen::AlignedBox3d box;
  Eigen::AlignedBox3d centers;  // Of three times the centroids.
  for (uint32_t i = begin; i < end; ++i) {
    const Triangle& triangle = triangles_[i];
    box.extend(triangle.a).extend(triangle.b).extend(triangle.c);
    centers.extend(Eigen::Vector3d(triangle.a + triangle.b + triangle.c));
  }
  nodes_[node].box = box;
  constexpr uint32_t kLeaf = 4;
  if (end - begin <= kLeaf) return;

  Eigen::Index axis = 0;
  centers.sizes().maxCoeff(&axis);
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(triangles_.begin() + begin,
                   triangles_.begin() + middle,
                   triangles_.begin() + end,
                   [axis](const Triangle& l, const Triangle& r) {
                     return l.a[axis] + l.b[axis] + l.c[axis] < r.a[axis] + r.b[axis] + r.c[axis];
                   });
  const auto children = static_cast<uint32_t>(nodes_.size());
  nodes_[node].children = children;
  nodes_.push_back({{}, begin, middle, 0});
  nodes_.push_back({{}, middle, end, 0});
  Build(children);
  Build(children + 1);
}

void NearestSurface::Search(uint32_t node, const Query& query, double* squared, Hit* hit) const {
  const Eigen::Vector3d& point = query.point;
  const Node& here = nodes_[node];
  if (here.children == 0) {
    for (uint32_t i = here.begin; i < here.end; ++i) {
      const auto& [a, b, c] = triangles_[i];
      const Eigen::Vector3d nearest = NearestOnTriangle(point, a, b, c);
      const double distance = (nearest - point).squaredNorm();
      if (distance >= *squared) continue;
      const Eigen::Vector3d normal = (b - a).cross(c - a);
      if (normal.dot(query.facing) < 0.0) continue;
      *squared = distance;
      hit->point = nearest;
      hit->normal = normal;
    }
    return;
  }
  uint32_t near = here.children;
  uint32_t far = here.children + 1;
  double near_distance = nodes_[near].box.squaredExteriorDistance(point);
  double far_distance = nodes_[far].box.squaredExteriorDistance(point);
  if (far_distance < near_distance) {
    std::swap(near, far);
    std::swap(near_distance, far_distance);
  }
  if (near_distance < *squared) Search(near, query, squared, hit);
  if (far_distance < *squared) Search(far, query, squared, hit);
}

NearestSurface::Hit NearestSurface::Nearest(const Eigen::Vector3d& point) const {
  return NearestWithin(point, std::sqrt(std::numeric_limits<double>::max()));
}

NearestSurface::Hit NearestSurface::NearestWithin(const Eigen::Vector3d& point,
                                                  double reach) const {
  return NearestFacing(point, Eigen::Vector3d::Zero(), reach);
}

NearestSurface::Hit NearestSurface::NearestFacing(const Eigen::Vector3d& point,
                                                  const Eigen::Vector3d& normal,
                                                  double reach) const {
  const double farthest = reach * reach;
  Hit hit{point, Eigen::Vector3d::UnitZ(), std::numeric_limits<double>::infinity()};
  double squared = farthest;
  Search(0, {point, normal}, &squared, &hit);
  if (squared >= farthest) return hit;
  hit.normal.normalize();
  hit.distance = std::sqrt(squared);
  return hit;
}

}  // namespace vantage
