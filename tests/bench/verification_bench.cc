// Drawing hypotheses and holding them against an image, beside Embree's rays through the same
// pixels. Every row goes through the same 64 hypotheses: 16 of each of four views at 0.7 m, one
// view after another, as they come when a cluster's hypotheses are ranked.

#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/depth_rasterizer.h"
#include "common/rng.h"
#include "perception/model/model_generator.h"
#include "perception/verification/mesh_decimation.h"
#include "perception/verification/verification.h"

namespace vantage {
namespace {

constexpr size_t kViews = 4;
constexpr size_t kHypothesesPerView = 16;
constexpr size_t kHypotheses = kViews * kHypothesesPerView;
constexpr CameraModel kCamera;

constexpr double kDiameter = 0.175;  // m

TriangleMesh Scaled(TriangleMesh mesh) {
  const auto factor = static_cast<float>(kDiameter / mesh.Diameter());
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= factor;
  return mesh;
}

// One view of the object before a wall, and hypotheses about it.
struct View {
  DepthImage depth;
  Segmentation segmentation;
  std::vector<Pose> hypotheses;
  ObservedImage observed;
};

struct Fixture {
  TriangleMesh triangles;
  DrawableMesh mesh;
  ModelShape shape;
  std::vector<View> views;

  explicit Fixture(size_t max_triangles)
      : triangles(Scaled(DecimateMesh(GenerateObject("cat").value().mesh, max_triangles, 0.02))),
        mesh(triangles),
        shape{mesh, mesh.center(), triangles.Diameter(), mesh.radius()},
        views(kViews) {
    Rng rng(1);
    for (View& view : views) Make(rng, &view);
  }
  void Make(Rng& rng, View* view) const;

  View& ViewOf(size_t i) { return views[i % kHypotheses / kHypothesesPerView]; }
  [[nodiscard]] const Pose& Hypothesis(size_t i) const {
    return views[i % kHypotheses / kHypothesesPerView].hypotheses[i % kHypothesesPerView];
  }
};

// The hypotheses are off by up to 20 deg and 20 mm: most are wrong, as they are when ranked.
void Fixture::Make(Rng& rng, View* view) const {
  const Eigen::Vector3d place(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), 0.7);
  const Eigen::Quaterniond rotation = rng.Rotation();
  const auto pose = [&](const Eigen::Quaterniond& q, const Eigen::Vector3d& at) {
    return Pose(Eigen::Translation3d(at) * q * Eigen::Translation3d(-shape.center));
  };
  DepthRasterizer rasterizer(kCamera);
  rasterizer.Draw(triangles, pose(rotation, place));
  view->depth = DepthImage(kCamera.width, kCamera.height, 1.2F);
  Cluster cluster;
  cluster.window = {kCamera.width, kCamera.height, -1, -1};
  view->segmentation.labels.assign(view->depth.depth.size(), Segmentation::kNoCluster);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const size_t i = view->depth.Index(u, v);
      const float z = rasterizer.depth()[i];
      if (z == DepthRasterizer::kEmpty) continue;
      view->depth.depth[i] = z + 0.0015F * static_cast<float>(rng.Normal());
      view->segmentation.labels[i] = 0;
      cluster.pixels.push_back(static_cast<uint32_t>(i));
      PixelWindow& window = cluster.window;
      window = {std::min(window.u0, u), std::min(window.v0, v), std::max(window.u1, u), v};
    }
  }
  view->segmentation.clusters.push_back(std::move(cluster));
  for (size_t i = 0; i < kHypothesesPerView; ++i) {
    const Eigen::AngleAxisd turn(rng.Uniform(0.0, 20.0) * kDegree, rng.UnitVector());
    view->hypotheses.push_back(pose(Eigen::Quaterniond(turn * rotation),
                                    place + rng.Uniform(0.0, 0.02) * rng.UnitVector()));
  }
}

Fixture& FixtureOf(int64_t triangles) {
  static Fixture coarse(500);
  static Fixture fine(5000);
  return triangles == 500 ? coarse : fine;
}

void Report(const Fixture& fixture, double pixels, benchmark::State* state) {
  state->SetItemsProcessed(state->iterations());
  state->counters["triangles"] = static_cast<double>(fixture.mesh.num_triangles());
  state->counters["pixels"] = pixels;
}

void BM_VerifyHypothesis(benchmark::State& state) {
  Fixture& fixture = FixtureOf(state.range(0));
  const int step = static_cast<int>(state.range(1));
  const VerificationParameters parameters;
  ModelView model_view;
  for (View& view : fixture.views) {
    view.observed.Reset({view.depth, kCamera, view.segmentation}, parameters.edge_px);
  }
  size_t i = 0;
  double pixels = 0.0;
  for (auto _ : state) {
    View& view = fixture.ViewOf(i);
    const Verification result = Verify(
        fixture.shape, fixture.Hypothesis(i), &view.observed, 0, step, parameters, &model_view);
    ++i;
    pixels += result.inliers + result.seen_through + result.in_front + result.edge;
  }
  Report(fixture, pixels / static_cast<double>(state.iterations()), &state);
}
BENCHMARK(BM_VerifyHypothesis)
    ->Args({500, 4})
    ->Args({5000, 4})
    ->Args({5000, 2})
    ->Args({5000, 1})
    ->Unit(benchmark::kMicrosecond);

// What an image costs beside its hypotheses.
void BM_PrepareImageAndVerifyOnce(benchmark::State& state) {
  Fixture& fixture = FixtureOf(500);
  const int step = static_cast<int>(state.range(0));
  const VerificationParameters parameters;
  ModelView model_view;
  ObservedImage observed;
  size_t i = 0;
  for (auto _ : state) {
    const View& view = fixture.ViewOf(i);
    observed.Reset({view.depth, kCamera, view.segmentation}, parameters.edge_px);
    benchmark::DoNotOptimize(
        Verify(fixture.shape, fixture.Hypothesis(i), &observed, 0, step, parameters, &model_view));
    ++i;
  }
}
BENCHMARK(BM_PrepareImageAndVerifyOnce)->Arg(1)->Arg(2)->Arg(4)->Unit(benchmark::kMicrosecond);

void BM_Render(benchmark::State& state) {
  const Fixture& fixture = FixtureOf(state.range(0));
  const int step = static_cast<int>(state.range(1));
  ModelView model_view;
  size_t i = 0;
  double pixels = 0.0;
  for (auto _ : state) {
    const Pose& T = fixture.Hypothesis(i++);
    model_view.Render(fixture.mesh, T, kCamera, ModelWindow(kCamera, fixture.shape, T), step);
  }
  model_view.ForEachPixel([&](const ModelView::Pixel&) { pixels += 1.0; });
  Report(fixture, pixels, &state);
}
BENCHMARK(BM_Render)->Args({500, 4})->Args({5000, 4})->Args({5000, 1})->Unit(
    benchmark::kMicrosecond);

// The peer: Embree's packets of eight rays through the pixels of the box of what is drawn.
class EmbreeScene {
 public:
  explicit EmbreeScene(const TriangleMesh& mesh)
      : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<Eigen::Vector3f*>(rtcSetNewGeometryBuffer(geometry,
                                                                           RTC_BUFFER_TYPE_VERTEX,
                                                                           0,
                                                                           RTC_FORMAT_FLOAT3,
                                                                           sizeof(Eigen::Vector3f),
                                                                           mesh.vertices.size()));
    std::copy(mesh.vertices.begin(), mesh.vertices.end(), vertices);
    auto* triangles =
        static_cast<std::array<uint32_t, 3>*>(rtcSetNewGeometryBuffer(geometry,
                                                                      RTC_BUFFER_TYPE_INDEX,
                                                                      0,
                                                                      RTC_FORMAT_UINT3,
                                                                      3 * sizeof(uint32_t),
                                                                      mesh.triangles.size()));
    std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  // Depth (m) of every step-th pixel of a window, row by row; infinite where nothing is met.
  void Render(const Pose& T_camera_mesh,
              const PixelWindow& window,
              int step,
              std::vector<float>* depth) const;

 private:
  RTCDevice device_;
  RTCScene scene_;
};

void EmbreeScene::Render(const Pose& T_camera_mesh,
                         const PixelWindow& window,
                         int step,
                         std::vector<float>* depth) const {
  const Eigen::Isometry3f T(T_camera_mesh.inverse().matrix().cast<float>());
  const Eigen::Vector3f origin = T.translation();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(32) const std::array<int, 8> all = {-1, -1, -1, -1, -1, -1, -1, -1};
  alignas(32) RTCRayHit8 packet;
  depth->clear();
  for (int v = window.v0; v <= window.v1; v += step) {
    for (int u = window.u0; u <= window.u1; u += 8 * step) {
      for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3f ray =
            T.linear() * kCamera.Unproject(u + i * step, v, 1.0).cast<float>();
        packet.ray.org_x[i] = origin.x();
        packet.ray.org_y[i] = origin.y();
        packet.ray.org_z[i] = origin.z();
        packet.ray.dir_x[i] = ray.x();
        packet.ray.dir_y[i] = ray.y();
        packet.ray.dir_z[i] = ray.z();
        packet.ray.tnear[i] = 0.0F;
        packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
        packet.ray.mask[i] = 0xffffffffU;
        packet.ray.flags[i] = 0;
        packet.ray.time[i] = 0.0F;
        packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      }
      rtcIntersect8(all.data(), scene_, &context, &packet);
      for (int i = 0; i < 8; ++i) depth->push_back(packet.ray.tfar[i]);
    }
  }
}

void BM_RenderByEmbree(benchmark::State& state) {
  const Fixture& fixture = FixtureOf(state.range(0));
  const int step = static_cast<int>(state.range(1));
  const EmbreeScene scene(fixture.triangles);
  std::vector<PixelWindow> windows;
  ModelView model_view;
  for (size_t k = 0; k < kHypotheses; ++k) {
    model_view.Render(fixture.mesh,
                      fixture.Hypothesis(k),
                      kCamera,
                      ModelWindow(kCamera, fixture.shape, fixture.Hypothesis(k)),
                      step);
    const PixelWindow& drawn = model_view.touched();
    windows.push_back({model_view.u0() + drawn.u0 * step,
                       model_view.v0() + drawn.v0 * step,
                       model_view.u0() + drawn.u1 * step,
                       model_view.v0() + drawn.v1 * step});
  }
  std::vector<float> depth;
  size_t i = 0;
  for (auto _ : state) {
    scene.Render(fixture.Hypothesis(i), windows[i % kHypotheses], step, &depth);
    ++i;
  }
  const auto pixels =
      std::count_if(depth.begin(), depth.end(), [](float z) { return std::isfinite(z); });
  Report(fixture, static_cast<double>(pixels), &state);
}
BENCHMARK(BM_RenderByEmbree)
    ->Args({500, 4})
    ->Args({5000, 4})
    ->Args({5000, 1})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace vantage
