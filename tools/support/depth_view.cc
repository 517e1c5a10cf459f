#include "tools/support/depth_view.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "tools/support/rgb_canvas.h"

namespace vantage {
namespace {

constexpr Rgb kNoDepth = {58, 60, 66};
constexpr double kMargin = 0.22;           // of the models' window, at each side
constexpr int kSmallestWindow = 160;       // px, of the depth image
constexpr float kStep = 0.006F;            // m, an edge inside a model
constexpr float kCreaseCosine = 0.82F;     // between normals of neighboring pixels
constexpr size_t kManyTriangles = 20'000;  // a scan: its creases are noise

void Extend(const PixelWindow& other, PixelWindow* window) {
  if (other.empty()) return;
  if (window->empty()) {
    *window = other;
    return;
  }
  window->u0 = std::min(window->u0, other.u0);
  window->v0 = std::min(window->v0, other.v0);
  window->u1 = std::max(window->u1, other.u1);
  window->v1 = std::max(window->v1, other.v1);
}

// The pixels that a drawn model really won.
PixelWindow DrawnWindow(const DepthRasterizer& rasterizer) {
  PixelWindow window;
  const int width = rasterizer.camera().width;
  const std::span<const float> depth = rasterizer.depth();
  for (size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] == DepthRasterizer::kEmpty) continue;
    const int u = static_cast<int>(i) % width;
    const int v = static_cast<int>(i) / width;
    Extend({u, v, u, v}, &window);
  }
  return window;
}

PixelWindow WindowOfModels(const CameraModel& camera, const std::vector<OutlinedModel>& models) {
  PixelWindow window;
  DepthRasterizer rasterizer(camera);
  for (const OutlinedModel& model : models) {
    rasterizer.Clear();
    rasterizer.Draw(*model.mesh, model.T_camera_mesh);
    Extend(DrawnWindow(rasterizer), &window);
  }
  if (window.empty()) return {0, 0, camera.width - 1, camera.height - 1};
  const auto grow = [](int* low, int* high) {
    const int size = *high - *low + 1;
    const int more = std::max(static_cast<int>(kMargin * size), (kSmallestWindow - size) / 2);
    *low -= more;
    *high += more;
  };
  grow(&window.u0, &window.u1);
  grow(&window.v0, &window.v1);
  return window;
}

// 3rd and 97th percentile of the depths that the picture shows.
void FindRange(const DepthImage& depth,
               const CameraModel& camera,
               const CameraModel& cut,
               double* near,
               double* far) {
  std::vector<float> values;
  const auto column = [&](double u) { return (u - cut.cx) / cut.fx * camera.fx + camera.cx; };
  const auto row = [&](double v) { return (v - cut.cy) / cut.fy * camera.fy + camera.cy; };
  const int u0 = std::max(0, static_cast<int>(column(0)));
  const int u1 = std::min(depth.width - 1, static_cast<int>(column(cut.width - 1)));
  const int v0 = std::max(0, static_cast<int>(row(0)));
  const int v1 = std::min(depth.height - 1, static_cast<int>(row(cut.height - 1)));
  for (int v = v0; v <= v1; ++v) {
    for (int u = u0; u <= u1; ++u) {
      if (std::isfinite(depth.at(u, v))) values.push_back(depth.at(u, v));
    }
  }
  *near = 0.0;
  *far = 1.0;
  if (values.empty()) return;
  std::sort(values.begin(), values.end());
  const auto quantile = [&values](double share) {
    return static_cast<double>(
        values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))]);
  };
  *near = quantile(0.03);
  *far = std::max(quantile(0.97), *near + 1e-3);
}

RgbImage ColorDepth(const DepthImage& depth,
                    const CameraModel& camera,
                    const CameraModel& cut,
                    double near,
                    double far) {
  RgbImage image = FilledImage(cut.width, cut.height, kNoDepth);
  for (int v = 0; v < cut.height; ++v) {
    for (int u = 0; u < cut.width; ++u) {
      const Eigen::Vector2d from = camera.Project(cut.Unproject(u, v, 1.0));
      const int du = static_cast<int>(std::lround(from.x()));
      const int dv = static_cast<int>(std::lround(from.y()));
      if (!depth.Contains(du, dv)) continue;
      const auto z = static_cast<double>(depth.at(du, dv));
      if (std::isfinite(z)) SetPixel(image, u, v, DepthColor((z - near) / (far - near)));
    }
  }
  return image;
}

enum class Edge : uint8_t { kNone, kInner, kSilhouette };

// Where a drawn model's picture changes from a pixel to the one right of or below it.
std::vector<Edge> FindEdges(const DepthRasterizer& rasterizer, const TriangleMesh& mesh) {
  const int width = rasterizer.camera().width;
  const int height = rasterizer.camera().height;
  const std::span<const float> depth = rasterizer.depth();
  const bool creases = mesh.triangles.size() < kManyTriangles;
  std::vector<Eigen::Vector3f> normals;
  for (size_t t = 0; creases && t < mesh.triangles.size(); ++t) {
    normals.push_back(mesh.ScaledNormal(t).normalized());
  }
  const auto compare = [&](size_t a, size_t b) {
    const bool in_a = depth[a] != DepthRasterizer::kEmpty;
    const bool in_b = depth[b] != DepthRasterizer::kEmpty;
    if (in_a != in_b) return Edge::kSilhouette;
    if (!in_a) return Edge::kNone;
    if (std::abs(depth[a] - depth[b]) > kStep) return Edge::kInner;
    if (!creases) return Edge::kNone;
    const float cosine =
        normals[rasterizer.triangle_ids()[a]].dot(normals[rasterizer.triangle_ids()[b]]);
    return cosine < kCreaseCosine ? Edge::kInner : Edge::kNone;
  };
  std::vector<Edge> edges(depth.size(), Edge::kNone);
  for (int v = 0; v + 1 < height; ++v) {
    for (int u = 0; u + 1 < width; ++u) {
      const size_t at =
          static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u);
      edges[at] = std::max(compare(at, at + 1), compare(at, at + static_cast<size_t>(width)));
    }
  }
  return edges;
}

void DrawOutline(const DepthRasterizer& rasterizer, const OutlinedModel& model, RgbImage& image) {
  const std::vector<Edge> edges = FindEdges(rasterizer, *model.mesh);
  const auto draw = [&](Edge kind, double radius, Rgb color, double coverage) {
    const int reach = static_cast<int>(std::ceil(radius));
    for (size_t i = 0; i < edges.size(); ++i) {
      if (edges[i] != kind) continue;
      const int u = static_cast<int>(i) % image.width;
      const int v = static_cast<int>(i) / image.width;
      for (int dv = -reach; dv <= reach; ++dv) {
        for (int du = -reach; du <= reach; ++du) {
          if (du * du + dv * dv <= radius * radius) {
            BlendPixel(image, u + du, v + dv, color, model.strength * coverage);
          }
        }
      }
    }
  };
  draw(Edge::kInner, 0.5, model.color, 0.75);
  draw(Edge::kSilhouette, 2.3, {255, 255, 255}, 0.45);
  draw(Edge::kSilhouette, 1.1, model.color, 1.0);
}

}  // namespace

CameraModel CutCamera(const CameraModel& camera, const PixelWindow& window, int width, int height) {
  const double window_width = window.u1 - window.u0 + 1;
  const double window_height = window.v1 - window.v0 + 1;
  const double scale = std::min(width / window_width, height / window_height);
  CameraModel cut;
  cut.width = width;
  cut.height = height;
  cut.fx = camera.fx * scale;
  cut.fy = camera.fy * scale;
  cut.cx = 0.5 * (width - 1) + scale * (camera.cx - 0.5 * (window.u0 + window.u1));
  cut.cy = 0.5 * (height - 1) + scale * (camera.cy - 0.5 * (window.v0 + window.v1));
  return cut;
}

DepthView DrawDepthView(const DepthImage& depth,
                        const CameraModel& camera,
                        const std::vector<OutlinedModel>& models,
                        int width,
                        int height) {
  return DrawDepthView(depth, camera, WindowOfModels(camera, models), models, width, height);
}

DepthView DrawDepthView(const DepthImage& depth,
                        const CameraModel& camera,
                        const PixelWindow& window,
                        const std::vector<OutlinedModel>& models,
                        int width,
                        int height) {
  const CameraModel cut = CutCamera(camera, window, width, height);
  DepthView view;
  FindRange(depth, camera, cut, &view.near, &view.far);
  view.image = ColorDepth(depth, camera, cut, view.near, view.far);
  DepthRasterizer rasterizer(cut);
  for (const OutlinedModel& model : models) {
    rasterizer.Clear();
    rasterizer.Draw(*model.mesh, model.T_camera_mesh);
    view.windows.push_back(DrawnWindow(rasterizer));
    DrawOutline(rasterizer, model, view.image);
  }
  return view;
}

}  // namespace vantage
