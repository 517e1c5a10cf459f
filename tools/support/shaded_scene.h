#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/camera_model.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"
#include "tools/support/color.h"
#include "tools/support/png_image.h"

namespace vantage {

/// A mesh in the scene; `mesh` outlives the rendering.
struct ShadedItem {
  const TriangleMesh* mesh = nullptr;
  Pose T_world_mesh = Pose::Identity();
  Rgb color;
};

/// A line in the scene, hidden (but faintly visible) behind what is nearer.
struct ShadedLine {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();  ///< m, world
  Eigen::Vector3d to = Eigen::Vector3d::Zero();    ///< m, world
  double width_px = 1.5;
  Rgb color;
};

struct ShadedScene {
  std::vector<ShadedItem> items;
  std::vector<ShadedLine> lines;
  Eigen::Vector3d light = {-0.8, -0.3, 0.75};  ///< Towards the lamp, world; any length.
};

/// The scene as seen by `camera`: Lambert shading with one lamp that throws shadows, light from the
/// sky, smooth normals except across creases, smooth edges.
RgbImage RenderShaded(const ShadedScene& scene,
                      const CameraModel& camera,
                      const Pose& T_world_camera);

/// Lines of a small camera: the four edges of its field of view to `depth` m and its image plane,
/// with a notch at the image's upper side.
std::vector<ShadedLine> FrustumLines(const CameraModel& camera,
                                     const Pose& T_world_camera,
                                     double depth,
                                     double width_px,
                                     Rgb color);

/// A rectangular table top, `thickness` m, whose upper side's middle is `center`.
TriangleMesh TableMesh(const Eigen::Vector3d& center,
                       double size_x,
                       double size_y,
                       double thickness);

}  // namespace vantage
