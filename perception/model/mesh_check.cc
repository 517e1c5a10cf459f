#include "perception/model/mesh_check.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "common/format.h"

namespace vantage {
namespace {

constexpr uint32_t kUnused = std::numeric_limits<uint32_t>::max();

Error Refused(const std::string& why) {
  return Error{ErrorCode::kInvalidArgument, "the mesh " + why};
}

Result<void> CheckNumbers(const TriangleMesh& mesh) {
  constexpr size_t kMost = 20'000'000;
  if (mesh.vertices.empty() || mesh.triangles.empty()) {
    return Refused("is empty, expected at least four triangles");
  }
  if (mesh.vertices.size() > kMost || mesh.triangles.size() > kMost) {
    return Refused(Format("has %zu vertices and %zu triangles, expected at most %zu each",
                          mesh.vertices.size(),
                          mesh.triangles.size(),
                          kMost));
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const uint32_t index : mesh.triangles[i]) {
      if (index < mesh.vertices.size()) continue;
      return Refused(Format("has a triangle (%zu) with vertex %u, expected 0 to %zu",
                            i,
                            index,
                            mesh.vertices.size() - 1));
    }
  }
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f& v = mesh.vertices[i];
    if (v.allFinite()) continue;
    return Refused(Format("has a vertex (%zu) at (%g, %g, %g), expected finite coordinates",
                          i,
                          static_cast<double>(v.x()),
                          static_cast<double>(v.y()),
                          static_cast<double>(v.z())));
  }
  return {};
}

// Vertices in exactly the same place become one; what no triangle uses goes. Order is kept.
size_t MergeVertices(TriangleMesh* mesh) {
  const size_t count = mesh->vertices.size();
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&mesh](uint32_t i) {
    const Eigen::Vector3f& v = mesh->vertices[i];
    return std::array<float, 3>{v.x(), v.y(), v.z()};
  };
  std::sort(order.begin(), order.end(), [&key](uint32_t a, uint32_t b) {
    return key(a) != key(b) ? key(a) < key(b) : a < b;
  });
  std::vector<uint32_t> first(count);
  for (size_t i = 0; i < count; ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  std::vector<uint32_t> renamed(count, kUnused);
  for (auto& triangle : mesh->triangles) {
    for (uint32_t& index : triangle) {
      index = first[index];
      renamed[index] = 0;
    }
  }
  std::vector<Eigen::Vector3f> kept;
  for (uint32_t i = 0; i < count; ++i) {
    if (renamed[i] == kUnused) continue;
    renamed[i] = static_cast<uint32_t>(kept.size());
    kept.push_back(mesh->vertices[i]);
  }
  for (auto& triangle : mesh->triangles) {
    for (uint32_t& index : triangle) index = renamed[index];
  }
  mesh->vertices = std::move(kept);
  return count - mesh->vertices.size();
}

size_t RemoveCollapsedTriangles(TriangleMesh* mesh) {
  return std::erase_if(mesh->triangles, [](const std::array<uint32_t, 3>& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  });
}

Result<void> CheckShape(const TriangleMesh& mesh) {
  const Eigen::Vector3d size = mesh.Bounds().sizes().cast<double>();
  const double diagonal = size.norm();
  // The bounding box's diagonal is within a factor of sqrt(3) of the diameter; what is far outside
  // is told before anything is computed from it.
  const double diameter =
      diagonal > 100.0 * kLargestDiameter || diagonal == 0.0 ? diagonal : mesh.Diameter();
  if (diameter < kSmallestDiameter || diameter > kLargestDiameter) {
    return Refused(
        Format("has a diameter of %.3g m, expected %g to %g m; it looks like a wrong "
               "--unit",
               diameter,
               kSmallestDiameter,
               kLargestDiameter));
  }
  const double area = mesh.Area();
  if (!(area > 1e-6 * diameter * diameter)) {
    return Refused(Format("has a surface of %.3g m^2, expected an area: it is degenerate", area));
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& v : mesh.vertices) mean += v.cast<double>();
  mean /= static_cast<double>(mesh.vertices.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& v : mesh.vertices) {
    const Eigen::Vector3d d = v.cast<double>() - mean;
    scatter += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  double thickness = 0.0;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    thickness = std::max(thickness, std::abs(normal.dot(v.cast<double>() - mean)));
  }
  if (thickness < 1e-4 * diameter) {
    return Refused(
        Format("is flat: all vertices lie within %.2g m of one plane, expected a body", thickness));
  }
  return {};
}

// Counts edges that are not shared by exactly two triangles in opposite directions.
void CountEdges(const TriangleMesh& mesh, MeshMending* mending) {
  struct Edge {
    uint64_t ends;
    bool forward;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const uint64_t from = triangle[i];
      const uint64_t to = triangle[(i + 1) % 3];
      edges.push_back({(std::min(from, to) << 32U) | std::max(from, to), from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.ends != b.ends ? a.ends < b.ends : a.forward < b.forward;
  });
  for (size_t i = 0; i < edges.size();) {
    size_t end = i;
    int balance = 0;
    for (; end < edges.size() && edges[end].ends == edges[i].ends; ++end) {
      balance += edges[end].forward ? 1 : -1;
    }
    if (end - i == 1) ++mending->open_edges;
    // Bodies that touch along an edge share it evenly: two triangles each way are no fault.
    if (end - i > 1 && balance != 0) ++mending->odd_edges;
    i = end;
  }
}

}  // namespace

double SignedVolume(const TriangleMesh& mesh) {
  double volume = 0.0;
  if (mesh.vertices.empty()) return volume;
  const Eigen::Vector3d origin = mesh.vertices.front().cast<double>();
  for (const auto& [ia, ib, ic] : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[ia].cast<double>() - origin;
    const Eigen::Vector3d b = mesh.vertices[ib].cast<double>() - origin;
    const Eigen::Vector3d c = mesh.vertices[ic].cast<double>() - origin;
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

Result<MeshMending> CheckAndMendMesh(TriangleMesh* mesh) {
  if (Result<void> sound = CheckNumbers(*mesh); !sound) return sound.error();
  MeshMending mending;
  mending.merged_vertices = MergeVertices(mesh);
  mending.removed_triangles = RemoveCollapsedTriangles(mesh);
  if (mesh->triangles.empty()) {
    return Refused("has only triangles without area, expected a body: it is degenerate");
  }
  if (Result<void> sound = CheckShape(*mesh); !sound) return sound.error();
  CountEdges(*mesh, &mending);
  // The volume of a mesh with a few holes, as of a scan, still tells inside from outside.
  constexpr double kMostOpen = 0.05;
  const double edges = 1.5 * static_cast<double>(mesh->triangles.size());
  const bool closed =
      static_cast<double>(mending.open_edges + mending.odd_edges) < kMostOpen * edges;
  if (closed && SignedVolume(*mesh) < 0.0) {
    for (auto& triangle : mesh->triangles) std::swap(triangle[1], triangle[2]);
    mending.flipped = true;
  }
  return mending;
}

}  // namespace vantage
