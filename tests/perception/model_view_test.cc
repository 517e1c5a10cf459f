#include "perception/verification/model_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "perception/model/model_generator.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = SmallCamera();
const PixelWindow kWhole{0, 0, kCamera.width - 1, kCamera.height - 1};

Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

// An open bowl, of which both sides can be seen.
TriangleMesh MakeBowl() {
  TriangleMesh mesh = MakeBox({-0.05F, -0.05F, -0.05F}, {0.05F, 0.05F, 0.05F}, 6);
  std::erase_if(mesh.triangles, [&](const auto& triangle) {
    return mesh.vertices[triangle[0]].z() + mesh.vertices[triangle[1]].z() +
               mesh.vertices[triangle[2]].z() >
           0.149F;
  });
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = 0.06F * vertex.normalized();
  return mesh;
}

TEST(DrawableMesh, KnowsWhetherItIsClosed) {
  EXPECT_TRUE(DrawableMesh(MakeAsymmetric()).is_closed());
  EXPECT_FALSE(DrawableMesh(MakeBowl()).is_closed());
  EXPECT_FALSE(DrawableMesh(MakeTable(1.0F)).is_closed());
  EXPECT_FALSE(DrawableMesh(TriangleMesh{}).is_closed());
  TriangleMesh inside_out = MakeAsymmetric();
  for (auto& [a, b, c] : inside_out.triangles) std::swap(b, c);
  EXPECT_FALSE(DrawableMesh(inside_out).is_closed());
  TriangleMesh one_flipped = MakeAsymmetric();
  std::swap(one_flipped.triangles[3][0], one_flipped.triangles[3][1]);
  EXPECT_FALSE(DrawableMesh(one_flipped).is_closed());
  // Two parts, one of which is inside out.
  TriangleMesh half = MakeAsymmetric();
  Append(inside_out, At(1.0, 0.0, 0.0), &half);
  EXPECT_FALSE(DrawableMesh(half).is_closed());
}

TEST(DrawableMesh, LeavesOutWhatIsNoTriangle) {
  TriangleMesh mesh = MakeBox({0.0F, 0.0F, 0.0F}, {0.1F, 0.1F, 0.1F});
  const size_t sound = mesh.triangles.size();
  const auto next = static_cast<uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(std::nanf(""), 0.0F, 0.0F);
  mesh.vertices.emplace_back(std::numeric_limits<float>::infinity(), 0.0F, 0.0F);
  mesh.triangles.push_back({0, 1, next});
  mesh.triangles.push_back({0, 1, next + 1});
  mesh.triangles.push_back({0, 1, next + 2});
  mesh.triangles.push_back({0, 0, 1});
  const DrawableMesh drawable(mesh);
  EXPECT_EQ(drawable.num_triangles(), sound);
  EXPECT_TRUE(drawable.is_closed());
  EXPECT_NEAR(drawable.radius(), std::sqrt(0.03) / 2, 1e-6);
}

TEST(ModelView, ShowsEveryStepthPixelOfTheWholeImage) {
  for (const TriangleMesh& triangles : {MakeAsymmetric(), MakeBowl()}) {
    const DrawableMesh mesh(triangles);
    const ModelShape shape{mesh, mesh.center(), 2.0 * mesh.radius(), mesh.radius()};
    Rng rng(2);
    ModelView view;
    for (int trial = 0; trial < 40; ++trial) {
      Pose T(rng.Rotation());
      // Some reach over the border.
      T.translation() = Eigen::Vector3d(rng.Uniform(-0.3, 0.3), rng.Uniform(-0.3, 0.3), 0.6);
      DepthRasterizer whole(kCamera);
      whole.Draw(triangles, T);
      const int step = 1 + trial % 4;
      view.Render(mesh, T, kCamera, ModelWindow(kCamera, shape, T), step);
      size_t shown = 0;
      view.ForEachPixel([&](const ModelView::Pixel& pixel) {
        const auto index = static_cast<size_t>(pixel.v * kCamera.width + pixel.u);
        EXPECT_EQ(pixel.u % step, 0);
        EXPECT_EQ(pixel.v % step, 0);
        if (whole.depth()[index] != DepthRasterizer::kEmpty) {
          EXPECT_NEAR(pixel.depth, whole.depth()[index], 1e-4);
        }
        ++shown;
      });
      size_t expected = 0;
      for (int v = 0; v < kCamera.height; v += step) {
        for (int u = 0; u < kCamera.width; u += step) {
          const auto index = static_cast<size_t>(v * kCamera.width + u);
          expected += whole.depth()[index] != DepthRasterizer::kEmpty ? 1U : 0U;
        }
      }
      // Pixels on an edge may fall to either side of the rounding.
      EXPECT_NEAR(static_cast<double>(shown), static_cast<double>(expected), 2.0);
    }
  }
}

TEST(ModelView, PlaneDistanceIsTheNormalsPartOfTheRay) {
  const DrawableMesh mesh(MakeAsymmetric());
  Pose T(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  T.translation() = Eigen::Vector3d(0.02, -0.03, 0.5);
  ModelView view;
  view.Render(mesh, T, kCamera, kWhole, 3);
  const Eigen::Matrix3f R = T.linear().cast<float>();
  int shown = 0;
  view.ForEachPixel([&](const ModelView::Pixel& pixel) {
    const Eigen::Vector3f ray = kCamera.Unproject(pixel.u, pixel.v, 1.0).cast<float>();
    const Eigen::Vector3f normal = VisibleNormal(mesh, R, pixel.triangle, ray);
    EXPECT_NEAR(-normal.dot(ray), pixel.plane_distance / pixel.depth, 1e-5);
    ++shown;
  });
  EXPECT_GT(shown, 100);
}

TEST(ModelView, ReachIsEveryPixelNearTheModel) {
  const DrawableMesh mesh(MakeAsymmetric());
  ModelView view;
  for (const int reach : {0, 1, 2, 5}) {
    view.Render(mesh, At(0.25, 0.0, 0.5), kCamera, kWhole, 2);
    std::vector<std::pair<int, int>> seen;
    for (int j = view.touched().v0; j <= view.touched().v1; ++j) {
      for (int i = view.touched().u0; i <= view.touched().u1; ++i) {
        if (view.inverse_depth()[view.Index(i, j)] > 0.0F) seen.emplace_back(i, j);
      }
    }
    ASSERT_GT(seen.size(), 50U);
    const ModelView::Reached reached = view.Reach(reach);
    EXPECT_EQ(reached.window.u0, view.touched().u0 - reach);
    for (int j = reached.window.v0; j <= reached.window.v1; ++j) {
      for (int i = reached.window.u0; i <= reached.window.u1; ++i) {
        const bool is_near = std::any_of(seen.begin(), seen.end(), [&](const auto& pixel) {
          return std::max(std::abs(pixel.first - i), std::abs(pixel.second - j)) <= reach;
        });
        EXPECT_EQ(reached.row(j)[i - reached.window.u0] != 0, is_near);
      }
    }
  }
}

TEST(ModelView, OfAWindowBehindTheCameraIsEmpty) {
  EXPECT_TRUE(BallWindow(kCamera, {0.0, 0.0, 0.1}, 0.2).empty());
  EXPECT_TRUE(BallWindow(kCamera, {0.0, 0.0, -1.0}, 0.2).empty());
  EXPECT_TRUE(BallWindow(kCamera, {0.0, 0.0, std::nan("")}, 0.2).empty());
  EXPECT_TRUE(BallWindow(kCamera, {50.0, 0.0, 1.0}, 0.2).empty());
  const DrawableMesh mesh(MakeAsymmetric());
  ModelView view;
  view.Render(mesh, At(0, 0, -1), kCamera, BallWindow(kCamera, {0, 0, -1}, 0.1), 1);
  EXPECT_TRUE(view.empty());
  view.Render(mesh, At(0, 0, -1), kCamera, kWhole, 1);
  EXPECT_TRUE(view.empty());
}

TEST(ModelView, ClipsAtTheNearPlane) {
  const TriangleMesh triangles = MakeBox({-0.1F, -0.1F, -0.3F}, {0.1F, 0.1F, 0.3F}, 3);
  const DrawableMesh mesh(triangles);
  Rng rng(4);
  ModelView view;
  int shown = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Pose T(rng.Rotation());
    T.translation() = 0.2 * rng.UnitVector();  // Mostly with the camera inside.
    DepthRasterizer reference(kCamera);
    reference.Draw(triangles, T);
    view.Render(mesh, T, kCamera, kWhole, 1);
    int different = 0;
    std::vector<float> drawn(reference.depth().size(), DepthRasterizer::kEmpty);
    view.ForEachPixel([&](const ModelView::Pixel& pixel) {
      drawn[static_cast<size_t>(pixel.v * kCamera.width + pixel.u)] = pixel.depth;
      ++shown;
    });
    for (size_t i = 0; i < drawn.size(); ++i) {
      if (drawn[i] == reference.depth()[i]) continue;
      different += std::abs(drawn[i] - reference.depth()[i]) < 1e-3F * drawn[i] ? 0 : 1;
    }
    EXPECT_LE(different, 10) << trial;
  }
  EXPECT_GT(shown, 500000);
}

TEST(ModelView, WithstandsPosesThatAreNone) {
  const DrawableMesh mesh(MakeAsymmetric());
  const DrawableMesh open(MakeBowl());
  ModelView view;
  for (const double bad : {std::nan(""),
                           std::numeric_limits<double>::infinity(),
                           1e300,
                           -1e300,
                           1e30,
                           1e10,
                           1e5,
                           1e-300}) {
    for (int element = 0; element < 12; ++element) {
      Pose T = At(0.0, 0.0, 0.5);
      T.matrix()(element % 3, element / 3) = bad;
      view.Render(mesh, T, kCamera, kWhole, 1);
      view.Render(open, T, kCamera, kWhole, 2);
      view.ForEachPixel([&](const ModelView::Pixel& pixel) {
        EXPECT_TRUE(pixel.depth > 0.0F);
        EXPECT_LT(pixel.u, kCamera.width);
        EXPECT_LT(pixel.v, kCamera.height);
      });
    }
  }
  view.Render(mesh, At(0, 0, 0.5), kCamera, {-2000000000, -5, 2000000000, 2000000000}, 1);
  EXPECT_FALSE(view.empty());
  view.Render(mesh, At(0, 0, 0.5), kCamera, {2000000000, 0, 2000000001, 5}, 7);
  EXPECT_TRUE(view.empty());
}

TEST(ModelView, IsTheSameOnBothPaths) {
  if (BestSimdPath() == SimdPath::kBaseline) GTEST_SKIP() << "no AVX2";
  ModelView baseline(SimdPath::kBaseline);
  ModelView best;
  Rng rng(5);
  for (const char* name : {"mug", "bracket"}) {
    const DrawableMesh mesh(GenerateObject(name).value().mesh);
    for (int trial = 0; trial < 12; ++trial) {
      Pose T(rng.Rotation());
      T.translation() = Eigen::Vector3d(rng.Uniform(-0.2, 0.2), 0.0, rng.Uniform(0.05, 0.6));
      const int step = 1 + trial % 4;
      baseline.Render(mesh, T, kCamera, kWhole, step);
      best.Render(mesh, T, kCamera, kWhole, step);
      std::vector<ModelView::Pixel> pixels;
      baseline.ForEachPixel([&](const ModelView::Pixel& pixel) { pixels.push_back(pixel); });
      size_t i = 0;
      best.ForEachPixel([&](const ModelView::Pixel& pixel) {
        ASSERT_LT(i, pixels.size());
        EXPECT_EQ(pixel.u, pixels[i].u);
        EXPECT_EQ(pixel.v, pixels[i].v);
        EXPECT_EQ(pixel.depth, pixels[i].depth);
        EXPECT_EQ(pixel.triangle, pixels[i].triangle);
        EXPECT_EQ(pixel.plane_distance, pixels[i].plane_distance);
        ++i;
      });
      EXPECT_EQ(i, pixels.size());
    }
  }
}

}  // namespace
}  // namespace vantage
