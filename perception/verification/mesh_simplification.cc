#include "perception/verification/mesh_simplification.h"

#include <cmath>
#include <set>
#include <unordered_map>

namespace vantage {

TriangleMesh SimplifyMesh(const TriangleMesh& mesh, double cell) {
  TriangleMesh simple;
  const auto inverse = static_cast<float>(1.0 / cell);
  const Eigen::Vector3f origin = mesh.Bounds().min();
  std::unordered_map<uint64_t, uint32_t> joined;
  std::vector<uint32_t> joined_of(mesh.vertices.size());
  std::vector<float> counts;
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<uint64_t>((mesh.vertices[i](axis) - origin(axis)) * inverse);
      key = (key << 21U) | (at & 0x1fffffU);
    }
    const auto next = static_cast<uint32_t>(simple.vertices.size());
    const auto [place, is_new] = joined.try_emplace(key, next);
    if (is_new) {
      simple.vertices.emplace_back(Eigen::Vector3f::Zero());
      counts.push_back(0.0F);
    }
    joined_of[i] = place->second;
    simple.vertices[place->second] += mesh.vertices[i];
    counts[place->second] += 1.0F;
  }
  for (size_t i = 0; i < counts.size(); ++i) simple.vertices[i] /= counts[i];
  std::set<std::array<uint32_t, 3>> known;
  for (const auto& [a, b, c] : mesh.triangles) {
    std::array<uint32_t, 3> triangle = {joined_of[a], joined_of[b], joined_of[c]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
      continue;
    }
    // The same triangle starts at its smallest vertex; its sense of rotation stays.
    while (triangle[0] > triangle[1] || triangle[0] > triangle[2]) {
      triangle = {triangle[1], triangle[2], triangle[0]};
    }
    if (known.insert(triangle).second) simple.triangles.push_back(triangle);
  }
  return simple;
}

}  // namespace vantage
