#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/triangle_mesh.h"
#include "perception/verification/triangle_block.h"

namespace vantage {

/// A mesh as ModelView draws it. Triangles have ids of their own here: block * 8 + lane.
class DrawableMesh {
 public:
  /// Triangles without area, or that are not finite, are left out.
  explicit DrawableMesh(TriangleMesh mesh);

  [[nodiscard]] size_t num_triangles() const { return num_triangles_; }
  /// As it was given.
  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  [[nodiscard]] std::span<const TriangleBlock> blocks() const { return blocks_; }
  /// True when every part of the surface is closed, and oriented outward: then no ray from outside
  /// meets a triangle's back first.
  [[nodiscard]] bool is_closed() const { return is_closed_; }
  /// Outward unit normal of a triangle.
  /// @param id as drawn (ModelView::Pixel::triangle), not an index into mesh().
  [[nodiscard]] Eigen::Vector3f normal(uint32_t id) const {
    const TriangleBlock& block = blocks_[id / TriangleBlock::kLanes];
    const size_t lane = id % TriangleBlock::kLanes;
    return {block.normal[0][lane], block.normal[1][lane], block.normal[2][lane]};
  }
  /// A ball that holds the mesh, m.
  [[nodiscard]] const Eigen::Vector3d& center() const { return center_; }
  [[nodiscard]] double radius() const { return radius_; }

 private:
  TriangleMesh mesh_;
  std::vector<TriangleBlock> blocks_;
  size_t num_triangles_ = 0;
  bool is_closed_ = false;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  double radius_ = 0.0;
};

}  // namespace vantage
