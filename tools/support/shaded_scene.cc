#include "tools/support/shaded_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/depth_rasterizer.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/smooth_normals.h"

namespace vantage {
namespace {

constexpr int kSupersampling = 2;
constexpr int kShadowMapSize = 1400;   // px
constexpr float kShadowBias = 0.004F;  // m
constexpr double kGamma = 2.2;

struct Lamp {
  Eigen::Vector3d direction;  // Unit, towards the lamp.
  Pose T_lamp_world;
  CameraModel camera;
  std::vector<float> depth;
};

Eigen::AlignedBox3d SceneBounds(const ShadedScene& scene) {
  Eigen::AlignedBox3d bounds;
  for (const ShadedItem& item : scene.items) {
    const Eigen::AlignedBox3d box = item.mesh->Bounds().cast<double>();
    for (int corner = 0; corner < 8; ++corner) {
      bounds.extend(item.T_world_mesh *
                    box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
    }
  }
  return bounds;
}

// A far-away lamp's view of the scene: what it does not see is in shadow.
Lamp MakeLamp(const ShadedScene& scene) {
  const Eigen::AlignedBox3d bounds = SceneBounds(scene);
  const double radius = std::max(0.5 * bounds.diagonal().norm(), 1e-3);
  const double distance = 12.0 * radius;
  Lamp lamp;
  lamp.direction = scene.light.normalized();
  lamp.T_lamp_world =
      LookAt(bounds.center() + distance * lamp.direction, bounds.center()).inverse();
  const double half = 0.5 * (kShadowMapSize - 1);
  const double focal = 0.98 * half * distance / radius;
  lamp.camera = {kShadowMapSize, kShadowMapSize, focal, focal, half, half};
  DepthRasterizer rasterizer(lamp.camera);
  rasterizer.Clear();
  for (const ShadedItem& item : scene.items) {
    rasterizer.Draw(*item.mesh, lamp.T_lamp_world * item.T_world_mesh);
  }
  lamp.depth.assign(rasterizer.depth().begin(), rasterizer.depth().end());
  return lamp;
}

// Share of the lamp's light that arrives at a point: mean over 5x5 texels, for soft edges.
double LitShare(const Lamp& lamp, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p_lamp = lamp.T_lamp_world * p_world;
  const Eigen::Vector2d pixel = lamp.camera.Project(p_lamp);
  int lit = 0;
  for (int dv = -2; dv <= 2; ++dv) {
    for (int du = -2; du <= 2; ++du) {
      const long u = std::lround(pixel.x()) + du;
      const long v = std::lround(pixel.y()) + dv;
      if (u < 0 || v < 0 || u >= kShadowMapSize || v >= kShadowMapSize) {
        ++lit;
        continue;
      }
      const size_t at = static_cast<size_t>(v) * kShadowMapSize + static_cast<size_t>(u);
      if (lamp.depth[at] > static_cast<float>(p_lamp.z()) - kShadowBias) ++lit;
    }
  }
  return lit / 25.0;
}

double Linear(uint8_t value) { return std::pow(value / 255.0, kGamma); }
uint8_t Encoded(double value) {
  return static_cast<uint8_t>(
      std::lround(255.0 * std::pow(std::clamp(value, 0.0, 1.0), 1.0 / kGamma)));
}

Rgb Shade(Rgb color, const Eigen::Vector3d& normal, const Lamp& lamp, double lit) {
  const double lambert = std::max(0.0, normal.dot(lamp.direction)) * lit;
  const double sky = 0.5 + 0.5 * normal.z();
  const double light = 0.30 + 0.22 * sky + 0.62 * lambert;
  return {Encoded(Linear(color.r) * light),
          Encoded(Linear(color.g) * light),
          Encoded(Linear(color.b) * light)};
}

// Draws lines in short pieces, each tested against the depth of what is there. Hidden ones mix with
// `surfaces`, the picture without any line: pieces overlap, and would add up to a solid line.
void DrawShadedLine(const ShadedLine& line,
                    const Pose& T_camera_world,
                    const DepthRasterizer& depth,
                    const RgbImage& surfaces,
                    RgbImage& image) {
  Eigen::Vector3d from = T_camera_world * line.from;
  Eigen::Vector3d to = T_camera_world * line.to;
  const double near = DepthRasterizer::kNear;
  if (from.z() < near && to.z() < near) return;
  if (from.z() < near) from = to + (from - to) * (to.z() - near) / (to.z() - from.z());
  if (to.z() < near) to = from + (to - from) * (from.z() - near) / (from.z() - to.z());
  const CameraModel& camera = depth.camera();
  const double length = (camera.Project(to) - camera.Project(from)).norm();
  const int pieces = std::clamp(static_cast<int>(length / 3.0), 1, 2000);
  for (int i = 0; i < pieces; ++i) {
    const Eigen::Vector3d a = from + (to - from) * i / pieces;
    const Eigen::Vector3d b = from + (to - from) * (i + 1) / pieces;
    const Eigen::Vector3d middle = 0.5 * (a + b);
    const Eigen::Vector2d pixel = camera.Project(middle);
    const long u = std::lround(pixel.x());
    const long v = std::lround(pixel.y());
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    const size_t at =
        static_cast<size_t>(v) * static_cast<size_t>(camera.width) + static_cast<size_t>(u);
    const bool hidden = depth.depth()[at] < static_cast<float>(middle.z()) - 0.002F;
    const Rgb color =
        hidden ? Mix(PixelAt(surfaces, static_cast<int>(u), static_cast<int>(v)), line.color, 0.25)
               : line.color;
    DrawLine(image, camera.Project(a), camera.Project(b), line.width_px * kSupersampling, color);
  }
}

Rgb Background(int v, int height) {
  return Mix({250, 251, 253}, {222, 227, 234}, static_cast<double>(v) / height);
}

}  // namespace

RgbImage RenderShaded(const ShadedScene& scene,
                      const CameraModel& camera,
                      const Pose& T_world_camera) {
  const CameraModel fine = camera.Scaled(kSupersampling);
  const Pose T_camera_world = T_world_camera.inverse();
  DepthRasterizer rasterizer(fine);
  rasterizer.Clear();
  std::vector<SmoothNormals> normals;
  for (size_t i = 0; i < scene.items.size(); ++i) {
    const ShadedItem& item = scene.items[i];
    rasterizer.Draw(*item.mesh, T_camera_world * item.T_world_mesh, static_cast<uint32_t>(i));
    normals.emplace_back(*item.mesh);
  }
  std::optional<Lamp> lamp;
  if (!scene.items.empty()) lamp = MakeLamp(scene);

  RgbImage image = FilledImage(fine.width, fine.height, {});
  for (int v = 0; v < fine.height; ++v) {
    for (int u = 0; u < fine.width; ++u) {
      const size_t at =
          static_cast<size_t>(v) * static_cast<size_t>(fine.width) + static_cast<size_t>(u);
      const uint32_t id = rasterizer.mesh_ids()[at];
      if (id == DepthRasterizer::kNoId) {
        SetPixel(image, u, v, Background(v, fine.height));
        continue;
      }
      const ShadedItem& item = scene.items[id];
      const Eigen::Vector3d p_world =
          T_world_camera * fine.Unproject(u, v, static_cast<double>(rasterizer.depth()[at]));
      const Eigen::Vector3f p_mesh = (item.T_world_mesh.inverse() * p_world).cast<float>();
      Eigen::Vector3d normal = item.T_world_mesh.linear() *
                               normals[id].At(rasterizer.triangle_ids()[at], p_mesh).cast<double>();
      if (normal.dot(p_world - T_world_camera.translation()) > 0.0) normal = -normal;
      SetPixel(image, u, v, Shade(item.color, normal, *lamp, LitShare(*lamp, p_world)));
    }
  }
  const RgbImage surfaces = image;
  for (const ShadedLine& line : scene.lines) {
    DrawShadedLine(line, T_camera_world, rasterizer, surfaces, image);
  }
  return Downsample(image, kSupersampling);
}

std::vector<ShadedLine> FrustumLines(const CameraModel& camera,
                                     const Pose& T_world_camera,
                                     double depth,
                                     double width_px,
                                     Rgb color) {
  const auto at = [&](double u, double v) -> Eigen::Vector3d {
    return T_world_camera * camera.Unproject(u, v, depth);
  };
  const double right = camera.width - 0.5;
  const double bottom = camera.height - 0.5;
  const std::array<Eigen::Vector3d, 4> corners = {
      at(-0.5, -0.5), at(right, -0.5), at(right, bottom), at(-0.5, bottom)};
  const Eigen::Vector3d eye = T_world_camera.translation();
  const Eigen::Vector3d notch = at(0.5 * right, -0.25 * camera.height);
  std::vector<ShadedLine> lines;
  for (size_t i = 0; i < 4; ++i) {
    lines.push_back({eye, corners[i], width_px, color});
    lines.push_back({corners[i], corners[(i + 1) % 4], width_px, color});
  }
  lines.push_back({corners[0], notch, width_px, color});
  lines.push_back({notch, corners[1], width_px, color});
  return lines;
}

TriangleMesh TableMesh(const Eigen::Vector3d& center,
                       double size_x,
                       double size_y,
                       double thickness) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d offset((corner & 1) != 0 ? 0.5 * size_x : -0.5 * size_x,
                                 (corner & 2) != 0 ? 0.5 * size_y : -0.5 * size_y,
                                 (corner & 4) != 0 ? 0.0 : -thickness);
    mesh.vertices.emplace_back((center + offset).cast<float>());
  }
  mesh.triangles = {{4, 5, 7},
                    {4, 7, 6},
                    {0, 3, 1},
                    {0, 2, 3},
                    {0, 1, 5},
                    {0, 5, 4},
                    {2, 7, 3},
                    {2, 6, 7},
                    {0, 4, 6},
                    {0, 6, 2},
                    {1, 3, 7},
                    {1, 7, 5}};
  return mesh;
}

}  // namespace vantage
