#include "drivers/sim/scene_renderer.h"

#include <cmath>
#include <utility>

namespace vantage {
namespace {

TriangleMesh PlaneMesh(const SimPlane& plane) {
  const auto x = static_cast<float>(0.5 * plane.size.x());
  const auto y = static_cast<float>(0.5 * plane.size.y());
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

}  // namespace

SceneRenderer::SceneRenderer(const SimScene& scene, const CameraModel& camera)
    : num_objects_(static_cast<uint32_t>(scene.objects.size())), rasterizer_(camera) {
  for (uint32_t i = 0; i < num_objects_; ++i) {
    AddBody(scene.objects[i].mesh, scene.objects[i].T_world_object, i);
  }
  // The large planes come last: most of their hidden pixels then fail the depth test.
  if (scene.table) AddBody(PlaneMesh(*scene.table), PlanePose(*scene.table), Table());
  if (scene.floor) AddBody(PlaneMesh(*scene.floor), PlanePose(*scene.floor), Floor());
  view_.camera = camera;
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
  view_.depth.width = view_.window.width();
  view_.depth.height = view_.window.height();
  const size_t size = rasterizer_.depth().size();
  view_.depth.depth.resize(size);
  view_.cos_incidence.resize(size);
  view_.surface.resize(size);
  size_t i = 0;
  for (int v = view_.window.v0; v <= view_.window.v1; ++v) {
    const auto y = static_cast<float>((v - camera.cy) / camera.fy);
    for (int u = view_.window.u0; u <= view_.window.u1; ++u, ++i) {
      const uint32_t body = rasterizer_.mesh_ids()[i];
      if (body == DepthRasterizer::kNoId) {
        view_.depth.depth[i] = DepthImage::kInvalid;
        view_.cos_incidence[i] = 0.0F;
        view_.surface[i] = RenderedView::kNoSurface;
        continue;
      }
      const float x = left + static_cast<float>(u) * inverse_fx;
      const Eigen::Vector3f& n = bodies_[body].normals_camera[rasterizer_.triangle_ids()[i]];
      const float dot = n.x() * x + n.y() * y + n.z();
      view_.depth.depth[i] = rasterizer_.depth()[i];
      view_.cos_incidence[i] = std::abs(dot) / std::sqrt(x * x + y * y + 1.0F);
      view_.surface[i] = bodies_[body].surface;
    }
  }
}

}  // namespace vantage
