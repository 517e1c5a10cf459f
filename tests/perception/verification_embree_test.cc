// What ModelView draws, pixel by pixel against rays traced by Embree.

#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "perception/model/model_generator.h"
#include "perception/verification/mesh_decimation.h"
#include "perception/verification/model_view.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = SmallCamera();

class RayTracer {
 public:
  explicit RayTracer(const TriangleMesh& mesh)
      : mesh_(mesh), device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto buffer = [&](RTCBufferType type, RTCFormat format, size_t count) {
      return rtcSetNewGeometryBuffer(geometry, type, 0, format, 12, count);
    };
    std::copy(mesh.vertices.begin(),
              mesh.vertices.end(),
              static_cast<Eigen::Vector3f*>(
                  buffer(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.vertices.size())));
    std::copy(mesh.triangles.begin(),
              mesh.triangles.end(),
              static_cast<std::array<uint32_t, 3>*>(
                  buffer(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles.size())));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~RayTracer() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  // Depth (m) along the ray of pixel (u, v) of the plane of the triangle that the ray through
  // (u + du, v + dv) meets first; nothing when it meets none.
  [[nodiscard]] std::optional<double> Depth(
      const Pose& T_camera_mesh, double u, double v, double du = 0.0, double dv = 0.0) const {
    const Pose T = T_camera_mesh.inverse();
    const Eigen::Vector3d origin = T.translation();
    const Eigen::Vector3d ray = T.linear() * kCamera.Unproject(u + du, v + dv, 1.0);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit hit{};
    hit.ray.org_x = static_cast<float>(origin.x());
    hit.ray.org_y = static_cast<float>(origin.y());
    hit.ray.org_z = static_cast<float>(origin.z());
    hit.ray.dir_x = static_cast<float>(ray.x());
    hit.ray.dir_y = static_cast<float>(ray.y());
    hit.ray.dir_z = static_cast<float>(ray.z());
    hit.ray.tfar = std::numeric_limits<float>::infinity();
    hit.ray.mask = 0xffffffffU;
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const auto& corner = mesh_.triangles[hit.hit.primID];
    const auto at = [&](size_t i) -> Eigen::Vector3d {
      return T_camera_mesh * mesh_.vertices[corner[i]].cast<double>();
    };
    const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0));
    return normal.dot(at(0)) / normal.dot(kCamera.Unproject(u, v, 1.0));
  }

 private:
  const TriangleMesh& mesh_;
  RTCDevice device_;
  RTCScene scene_;
};

struct Agreement {
  int seen = 0;
  int at_edges = 0;  // Only a ray 1e-3 px away agrees.
  int wrong = 0;     // None does.
};

bool Agree(const std::optional<double>& expected, float depth) {
  if (!expected) return depth == 0.0F;
  return std::abs(static_cast<double>(depth) - *expected) <= 1e-5 * *expected;
}

bool AgreesNearby(const RayTracer& tracer, const Pose& T, int u, int v, float depth) {
  constexpr int kAround = 16;
  for (int i = 0; i < kAround; ++i) {
    const double angle = 360.0 * kDegree * i / kAround;
    const double away = i % 2 == 0 ? 1e-3 : 3e-4;  // px
    if (Agree(tracer.Depth(T, u, v, away * std::cos(angle), away * std::sin(angle)), depth)) {
      return true;
    }
  }
  return false;
}

void Compare(const RayTracer& tracer,
             const Pose& T,
             const ModelView& view,
             const PixelWindow& window,
             Agreement* agreement) {
  std::vector<float> drawn(static_cast<size_t>(kCamera.width * kCamera.height), 0.0F);
  view.ForEachPixel([&](const ModelView::Pixel& pixel) {
    drawn[static_cast<size_t>(pixel.v * kCamera.width + pixel.u)] = pixel.depth;
  });
  const int step = view.step();
  for (int v = (window.v0 + step - 1) / step * step; v <= window.v1; v += step) {
    for (int u = (window.u0 + step - 1) / step * step; u <= window.u1; u += step) {
      const float depth = drawn[static_cast<size_t>(v * kCamera.width + u)];
      agreement->seen += depth > 0.0F ? 1 : 0;
      if (Agree(tracer.Depth(T, u, v), depth)) continue;
      ++(AgreesNearby(tracer, T, u, v, depth) ? agreement->at_edges : agreement->wrong);
    }
  }
}

void ExpectAgreement(const TriangleMesh& mesh, uint64_t seed) {
  const DrawableMesh drawable(mesh);
  const ModelShape shape{drawable, drawable.center(), 2.0 * drawable.radius(), drawable.radius()};
  const RayTracer tracer(mesh);
  Rng rng(seed);
  Agreement agreement;
  ModelView view;
  for (int trial = 0; trial < 12; ++trial) {
    Pose T(rng.Rotation());
    T.translation() = Eigen::Vector3d(rng.Uniform(-0.15, 0.15),
                                      rng.Uniform(-0.15, 0.15),
                                      drawable.radius() + rng.Uniform(0.3, 0.7));
    const PixelWindow window = ModelWindow(kCamera, shape, T);
    view.Render(drawable, T, kCamera, window, 1 + trial % 4);
    Compare(tracer, T, view, window, &agreement);
  }
  EXPECT_EQ(agreement.wrong, 0);
  EXPECT_LE(agreement.at_edges, 1 + agreement.seen / 500);
  EXPECT_GT(agreement.seen, 1000);
}

TEST(ModelViewByRays, AgreesOnBoxes) {
  ExpectAgreement(MakeAsymmetric(), 1);
  ExpectAgreement(MakeBox({-0.1F, -0.05F, -0.02F}, {0.1F, 0.05F, 0.02F}, 20), 2);
}

TEST(ModelViewByRays, AgreesOnAnOpenSheet) { ExpectAgreement(MakeTable(0.2F), 3); }

TEST(ModelViewByRays, AgreesOnAMeshWithHoles) {
  TriangleMesh mesh = GenerateObject("duck").value().mesh;
  Rng rng(4);
  std::erase_if(mesh.triangles, [&](const auto&) { return rng.Below(4) == 0; });
  ExpectAgreement(mesh, 4);
}

TEST(ModelViewByRays, AgreesOnGeneratedObjects) {
  uint64_t seed = 5;
  for (const char* name : {"mug", "bracket", "gear", "cat", "bottle"}) {
    SCOPED_TRACE(name);
    ExpectAgreement(GenerateObject(name).value().mesh, ++seed);
  }
}

TEST(ModelViewByRays, AgreesOnDecimatedObjects) {
  uint64_t seed = 20;
  for (const char* name : {"duck", "mug", "spray"}) {
    SCOPED_TRACE(name);
    const TriangleMesh mesh = GenerateObject(name).value().mesh;
    ExpectAgreement(DecimateMesh(mesh, kCoarseLevel), ++seed);
    ExpectAgreement(DecimateMesh(mesh, kFineLevel), ++seed);
  }
}

}  // namespace
}  // namespace vantage
