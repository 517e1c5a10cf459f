#include "drivers/sim/scene_renderer.h"

#include <cmath>
#include <span>
#include <utility>

#include "common/simd.h"

namespace vantage {
namespace {

TriangleMesh RectangleMesh(const Eigen::Vector2d& size) {
  const auto x = static_cast<float>(0.5 * size.x());
  const auto y = static_cast<float>(0.5 * size.y());
  TriangleMesh mesh;
  mesh.vertices = {{-x, -y, 0.0F}, {x, -y, 0.0F}, {x, y, 0.0F}, {-x, y, 0.0F}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Pose PlanePose(const SimPlane& plane) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(plane.center.x(), plane.center.y(), plane.height);
  return pose;
}

// The rays (x, y, 1) of a row of pixels.
struct RayRow {
  float left, step;  // x = left + step u
  float y;
  int u0;  // px, the first
};

struct NormalRow {
  const float *x, *y, *z;
};

VANTAGE_SIMD void FindCosines(const RayRow& rays,
                              const NormalRow& normals,
                              const float* lengths,
                              size_t count,
                              float* cosines) {
  for (size_t i = 0; i < count; ++i) {
    const float x = rays.left + static_cast<float>(rays.u0 + static_cast<int>(i)) * rays.step;
    const float dot = normals.x[i] * x + normals.y[i] * rays.y + normals.z[i];
    cosines[i] = std::abs(dot) / lengths[i];
  }
}

}  // namespace

SceneRenderer::SceneRenderer(const SimScene& scene, const CameraModel& camera)
    : num_objects_(static_cast<uint32_t>(scene.objects.size())), rasterizer_(camera) {
  for (uint32_t i = 0; i < num_objects_; ++i) {
    AddBody(scene.objects[i].mesh, scene.objects[i].T_world_object, i);
  }
  if (scene.board) AddBody(RectangleMesh(scene.board->size), scene.board->T_world_board, Board());
  // The large planes come last: most of their hidden pixels then fail the depth test.
  if (scene.table) AddBody(RectangleMesh(scene.table->size), PlanePose(*scene.table), Table());
  if (scene.floor) AddBody(RectangleMesh(scene.floor->size), PlanePose(*scene.floor), Floor());
  view_.camera = camera;
  FindRayLengths();
}

void SceneRenderer::FindRayLengths() {
  const CameraModel& camera = view_.camera;
  const auto inverse_fx = static_cast<float>(1.0 / camera.fx);
  const float left = -static_cast<float>(camera.cx / camera.fx);
  ray_lengths_.reserve(static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    const auto y = static_cast<float>((v - camera.cy) / camera.fy);
    for (int u = 0; u < camera.width; ++u) {
      const float x = left + static_cast<float>(u) * inverse_fx;
      ray_lengths_.push_back(std::sqrt(x * x + y * y + 1.0F));
    }
  }
}

void SceneRenderer::AddBody(TriangleMesh mesh, const Pose& T_world_body, uint32_t surface) {
  Body body;
  body.mesh = std::move(mesh);
  body.T_world_body = T_world_body;
  body.surface = surface;
  body.normals.reserve(body.mesh.triangles.size());
  for (size_t i = 0; i < body.mesh.triangles.size(); ++i) {
    body.normals.push_back(body.mesh.ScaledNormal(i).stableNormalized());
  }
  body.normals_camera.resize(body.normals.size());
  bodies_.push_back(std::move(body));
}

const RenderedView& SceneRenderer::Render(const Pose& T_world_camera, const PixelWindow& window) {
  const Pose T_camera_world = T_world_camera.inverse(Eigen::Isometry);
  rasterizer_.Clear(window);
  view_.window = window;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    const Pose T_camera_body = T_camera_world * body.T_world_body;
    rasterizer_.Draw(body.mesh, T_camera_body, static_cast<uint32_t>(i));
    const Eigen::Matrix3f R = T_camera_body.linear().cast<float>();
    for (size_t j = 0; j < body.normals.size(); ++j) {
      body.normals_camera[j] = R * body.normals[j];
    }
  }
  FillView();
  return view_;
}

void SceneRenderer::FillView() {
  const CameraModel& camera = view_.camera;
  const auto inverse_fx = static_cast<float>(1.0 / camera.fx);
  const float left = -static_cast<float>(camera.cx / camera.fx);
  const auto width = static_cast<size_t>(view_.window.width());
  view_.depth.width = view_.window.width();
  view_.depth.height = view_.window.height();
  const std::span<const float> depth = rasterizer_.depth();
  const std::span<const uint32_t> bodies = rasterizer_.mesh_ids();
  const std::span<const uint32_t> triangles = rasterizer_.triangle_ids();
  view_.depth.depth.resize(depth.size());
  view_.cos_incidence.resize(depth.size());
  view_.surface.resize(depth.size());
  normals_x_.resize(width);
  normals_y_.resize(width);
  normals_z_.resize(width);
  size_t i = 0;
  for (int v = view_.window.v0; v <= view_.window.v1; ++v) {
    const auto y = static_cast<float>((v - camera.cy) / camera.fy);
    float* cosines = view_.cos_incidence.data() + i;
    for (size_t u = 0; u < width; ++u, ++i) {
      const uint32_t body = bodies[i];
      const bool is_hit = body != DepthRasterizer::kNoId;
      const Eigen::Vector3f n = is_hit ? bodies_[body].normals_camera[triangles[i]]
                                       : Eigen::Vector3f(Eigen::Vector3f::Zero());
      normals_x_[u] = n.x();
      normals_y_[u] = n.y();
      normals_z_[u] = n.z();
      view_.depth.depth[i] = is_hit ? depth[i] : DepthImage::kInvalid;
      view_.surface[i] = is_hit ? bodies_[body].surface : RenderedView::kNoSurface;
    }
    FindCosines({left, inverse_fx, y, view_.window.u0},
                {normals_x_.data(), normals_y_.data(), normals_z_.data()},
                ray_lengths_.data() + static_cast<size_t>(v) * static_cast<size_t>(camera.width) +
                    static_cast<size_t>(view_.window.u0),
                width,
                cosines);
  }
}

}  // namespace vantage
