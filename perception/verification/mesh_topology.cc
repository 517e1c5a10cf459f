#include "perception/verification/mesh_topology.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace vantage {
namespace {

// For every vertex the first, in the order of coordinates, that is at its place.
std::vector<uint32_t> FirstAtPlace(const std::vector<Eigen::Vector3f>& vertices) {
  std::vector<uint32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](uint32_t i) {
    return std::array{vertices[i].x(), vertices[i].y(), vertices[i].z()};
  };
  std::erase_if(order, [&](uint32_t i) { return !vertices[i].allFinite(); });
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return std::pair(key(a), a) < std::pair(key(b), b);
  });
  std::vector<uint32_t> first(vertices.size());
  std::iota(first.begin(), first.end(), 0U);
  for (size_t i = 1; i < order.size(); ++i) {
    if (key(order[i]) == key(order[i - 1])) first[order[i]] = first[order[i - 1]];
  }
  return first;
}

// A vertex that stands for all that are connected with it.
uint32_t Root(std::vector<uint32_t>* parents, uint32_t vertex) {
  std::vector<uint32_t>& parent = *parents;
  while (parent[vertex] != vertex) vertex = parent[vertex] = parent[parent[vertex]];
  return vertex;
}

bool EdgesCancel(const TriangleMesh& mesh) {
  struct Edge {
    uint32_t low;
    uint32_t high;
    int sense;
    auto operator<=>(const Edge&) const = default;
  };
  std::vector<Edge> edges;
  for (const auto& triangle : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t from = triangle[i];
      const uint32_t to = triangle[(i + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), from < to ? 1 : -1});
    }
  }
  std::sort(edges.begin(), edges.end());
  for (size_t i = 0; i < edges.size();) {
    int sum = 0;
    const Edge first = edges[i];
    for (; i < edges.size() && edges[i].low == first.low && edges[i].high == first.high; ++i) {
      sum += edges[i].sense;
    }
    if (sum != 0) return false;
  }
  return true;
}

}  // namespace

TriangleMesh WeldVertices(const TriangleMesh& mesh) {
  TriangleMesh welded;
  const std::vector<uint32_t> first = FirstAtPlace(mesh.vertices);
  constexpr uint32_t kUnused = 0xffffffffU;
  std::vector<uint32_t> place(mesh.vertices.size(), kUnused);
  for (const auto& triangle : mesh.triangles) {
    std::array<uint32_t, 3> corners{};
    bool is_whole = true;
    for (size_t i = 0; i < 3; ++i) {
      is_whole = is_whole && triangle[i] < first.size();
      if (is_whole) corners[i] = first[triangle[i]];
    }
    if (!is_whole) continue;
    const auto& [a, b, c] = corners;
    const std::vector<Eigen::Vector3f>& at = mesh.vertices;
    const float area = (at[b] - at[a]).cross(at[c] - at[a]).norm();
    if (!(area > 0.0F) || !std::isfinite(area)) continue;
    for (uint32_t& corner : corners) {
      if (place[corner] == kUnused) {
        place[corner] = static_cast<uint32_t>(welded.vertices.size());
        welded.vertices.push_back(at[corner]);
      }
      corner = place[corner];
    }
    welded.triangles.push_back(corners);
  }
  return welded;
}

bool IsClosed(const TriangleMesh& mesh) {
  if (mesh.triangles.empty() || !EdgesCancel(mesh)) return false;
  std::vector<uint32_t> parents(mesh.vertices.size());
  std::iota(parents.begin(), parents.end(), 0U);
  for (const auto& [a, b, c] : mesh.triangles) {
    parents[Root(&parents, b)] = Root(&parents, a);
    parents[Root(&parents, c)] = Root(&parents, a);
  }
  std::vector<double> volume(mesh.vertices.size(), 0.0);
  for (const auto& [a, b, c] : mesh.triangles) {
    const uint32_t root = Root(&parents, a);
    const auto relative = [&](uint32_t vertex) -> Eigen::Vector3d {
      return (mesh.vertices[vertex] - mesh.vertices[root]).cast<double>();
    };
    volume[root] += relative(a).dot(relative(b).cross(relative(c)));
  }
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& triangle) {
    return volume[Root(&parents, triangle[0])] > 0.0;
  });
}

}  // namespace vantage
