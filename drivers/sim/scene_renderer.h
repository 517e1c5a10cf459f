#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "drivers/sim/scene.h"

namespace vantage {

/// What an ideal camera sees, pixel by pixel.
struct RenderedView {
  static constexpr uint32_t kNoSurface = DepthRasterizer::kNoId;

  CameraModel camera;
  PixelWindow window;  ///< the camera's pixels that follow, row by row
  DepthImage depth;    ///< m; NaN where there is no surface
  /// |cosine| of the angle between the ray and the surface's normal; 0 where there is no surface.
  std::vector<float> cos_incidence;
  std::vector<uint32_t> surface;  ///< index of the object; Table(), Floor(), Board(); kNoSurface
};

/// Renders a scene's depth, its surfaces and the angles at which the rays meet them.
class SceneRenderer {
 public:
  SceneRenderer(const SimScene& scene, const CameraModel& camera);

  /// Moves an object of the scene.
  void MoveObject(size_t object, const Pose& T_world_object) {
    bodies_[object].T_world_body = T_world_object;
  }
  /// The view from a pose; valid until the next call.
  const RenderedView& Render(const Pose& T_world_camera) {
    return Render(T_world_camera, WholeImage(view_.camera));
  }
  /// Only a window of it, not empty.
  const RenderedView& Render(const Pose& T_world_camera, const PixelWindow& window);

  /// RenderedView::surface of the table, of the floor, and of the printed board.
  [[nodiscard]] uint32_t Table() const { return num_objects_; }
  [[nodiscard]] uint32_t Floor() const { return num_objects_ + 1; }
  [[nodiscard]] uint32_t Board() const { return num_objects_ + 2; }

 private:
  struct Body {
    TriangleMesh mesh;
    Pose T_world_body = Pose::Identity();
    uint32_t surface = 0;
    std::vector<Eigen::Vector3f> normals;         // By triangle, in the body's frame.
    std::vector<Eigen::Vector3f> normals_camera;  // Reused: the same in the camera's frame.
  };

  void AddBody(TriangleMesh mesh, const Pose& T_world_body, uint32_t surface);
  void FindRayLengths();
  void FillView();

  uint32_t num_objects_;
  DepthRasterizer rasterizer_;
  std::vector<Body> bodies_;
  std::vector<float> ray_lengths_;  // Of (x, y, 1) through each of the camera's pixels.
  RenderedView view_;
  std::vector<float> normals_x_, normals_y_, normals_z_;  // Reused: of a row's pixels.
};

}  // namespace vantage
