#pragma once

#include <array>
#include <cmath>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "common/rng.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// A box from `low` to `high`, outward triangles, every face divided so that it has many vertices.
inline TriangleMesh MakeBox(const Eigen::Vector3f& low,
                            const Eigen::Vector3f& high,
                            int cells = 1) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const int a = (axis + 1) % 3;
      const int b = (axis + 2) % 3;
      const auto offset = static_cast<uint32_t>(mesh.vertices.size());
      for (int i = 0; i <= cells; ++i) {
        for (int j = 0; j <= cells; ++j) {
          Eigen::Vector3f vertex;
          vertex(axis) = side == 0 ? low(axis) : high(axis);
          const float along_a = static_cast<float>(i) / static_cast<float>(cells);
          const float along_b = static_cast<float>(j) / static_cast<float>(cells);
          vertex(a) = low(a) + along_a * (high(a) - low(a));
          vertex(b) = low(b) + along_b * (high(b) - low(b));
          mesh.vertices.push_back(vertex);
        }
      }
      const auto row = static_cast<uint32_t>(cells + 1);
      for (uint32_t i = 0; i + 1 < row; ++i) {
        for (uint32_t j = 0; j + 1 < row; ++j) {
          const uint32_t p = offset + i * row + j;
          const std::array<uint32_t, 4> quad = {p, p + row, p + row + 1, p + 1};
          if (side == 1) {
            mesh.triangles.push_back({quad[0], quad[1], quad[2]});
            mesh.triangles.push_back({quad[0], quad[2], quad[3]});
          } else {
            mesh.triangles.push_back({quad[0], quad[2], quad[1]});
            mesh.triangles.push_back({quad[0], quad[3], quad[2]});
          }
        }
      }
    }
  }
  return mesh;
}

/// Three boxes that no rotation maps onto themselves; 0.10 x 0.06 x 0.08 m, base at z = 0.
inline TriangleMesh MakeAsymmetric() {
  TriangleMesh mesh = MakeBox({0.0F, 0.0F, 0.0F}, {0.10F, 0.06F, 0.02F});
  Append(MakeBox({0.0F, 0.0F, 0.02F}, {0.025F, 0.06F, 0.08F}), Pose::Identity(), &mesh);
  Append(MakeBox({0.06F, 0.0F, 0.02F}, {0.10F, 0.03F, 0.045F}), Pose::Identity(), &mesh);
  return mesh;
}

/// A level square of `side` m at height 0.
inline TriangleMesh MakeTable(float side) {
  TriangleMesh mesh;
  const float h = 0.5F * side;
  mesh.vertices = {{-h, -h, 0.0F}, {h, -h, 0.0F}, {h, h, 0.0F}, {-h, h, 0.0F}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

inline CameraModel SmallCamera() {
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 285.0;
  camera.cx = 159.5;
  camera.cy = 119.5;
  return camera;
}

inline DepthImage ToImage(const DepthRasterizer& rasterizer) {
  const CameraModel& camera = rasterizer.camera();
  DepthImage image(camera.width, camera.height);
  for (size_t i = 0; i < image.depth.size(); ++i) {
    const float depth = rasterizer.depth()[i];
    if (depth != DepthRasterizer::kEmpty) image.depth[i] = depth;
  }
  return image;
}

/// Noise of `sigma` m at 1 m that grows with the square, and steps of `step` px of disparity for a
/// baseline of 75 mm.
inline void AddNoise(double focal, double sigma, double step, Rng& rng, DepthImage* image) {
  for (float& depth : image->depth) {
    if (!(depth > 0.0F)) continue;
    double z = static_cast<double>(depth);
    z += sigma * z * z * rng.Normal();
    if (step > 0.0) z = focal * 0.075 / (step * std::round(focal * 0.075 / z / step));
    depth = static_cast<float>(z);
  }
}

}  // namespace vantage
