#include "perception/verification/drawable_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "perception/verification/mesh_topology.h"

namespace vantage {
namespace {

TriangleBlock EmptyBlock() {
  TriangleBlock block{};
  std::fill(
      std::begin(block.offset), std::end(block.offset), std::numeric_limits<float>::infinity());
  return block;
}

// The plane of a triangle; it was checked that it has area.
void SetPlane(const Eigen::Vector3f& a,
              const Eigen::Vector3f& b,
              const Eigen::Vector3f& c,
              size_t lane,
              TriangleBlock* block) {
  const Eigen::Vector3d from = a.cast<double>();
  const Eigen::Vector3d normal =
      (b.cast<double>() - from).cross(c.cast<double>() - from).normalized();
  for (int axis = 0; axis < 3; ++axis) {
    block->normal[axis][lane] = static_cast<float>(normal(axis));
  }
  block->offset[lane] = static_cast<float>(normal.dot(from));
}

// Neighboring triangles in as few blocks as may be.
std::vector<TriangleBlock> MakeBlocks(const TriangleMesh& mesh) {
  constexpr size_t kLanes = TriangleBlock::kLanes;
  if (mesh.triangles.empty()) return {};
  const std::span<const uint32_t> indices(mesh.triangles.front().data(), 3 * mesh.triangles.size());
  const size_t most = meshopt_buildMeshletsBound(indices.size(), kLanes, kLanes);
  std::vector<meshopt_Meshlet> parts(most);
  std::vector<uint32_t> vertices(most * kLanes);
  std::vector<uint8_t> corners(most * kLanes * 3);
  constexpr float kConeWeight = 0.5F;  // Blocks that face one way are passed over whole.
  parts.resize(meshopt_buildMeshlets(parts.data(),
                                     vertices.data(),
                                     corners.data(),
                                     indices.data(),
                                     indices.size(),
                                     mesh.vertices.front().data(),
                                     mesh.vertices.size(),
                                     sizeof(Eigen::Vector3f),
                                     kLanes,
                                     kLanes,
                                     kConeWeight));
  std::vector<TriangleBlock> blocks;
  blocks.reserve(parts.size());
  for (const meshopt_Meshlet& part : parts) {
    TriangleBlock block = EmptyBlock();
    for (size_t lane = 0; lane < kLanes; ++lane) {
      // Lanes without a vertex repeat the last.
      const size_t known = std::min<size_t>(lane, part.vertex_count - 1);
      const Eigen::Vector3f& vertex = mesh.vertices[vertices[part.vertex_offset + known]];
      for (int axis = 0; axis < 3; ++axis) block.vertex[axis][lane] = vertex(axis);
    }
    for (size_t lane = 0; lane < part.triangle_count; ++lane) {
      const uint8_t* corner = &corners[part.triangle_offset + 3 * lane];
      for (size_t i = 0; i < 3; ++i) block.corner[i][lane] = corner[i];
      const auto at = [&](size_t i) -> const Eigen::Vector3f& {
        return mesh.vertices[vertices[part.vertex_offset + corner[i]]];
      };
      SetPlane(at(0), at(1), at(2), lane, &block);
    }
    blocks.push_back(block);
  }
  return blocks;
}

}  // namespace

DrawableMesh::DrawableMesh(TriangleMesh mesh) : mesh_(std::move(mesh)) {
  const TriangleMesh welded = WeldVertices(mesh_);
  num_triangles_ = welded.triangles.size();
  is_closed_ = IsClosed(welded);
  blocks_ = MakeBlocks(welded);
  if (welded.vertices.empty()) return;
  center_ = welded.Bounds().center().cast<double>();
  for (const Eigen::Vector3f& vertex : welded.vertices) {
    radius_ = std::max(radius_, (vertex.cast<double>() - center_).norm());
  }
}

}  // namespace vantage
