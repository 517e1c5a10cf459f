#include "planner/occlusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/depth_rasterizer.h"
#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

PlannedObject Standing(const TriangleMesh& mesh, double x, double y, double angle) {
  PlannedObject object;
  object.mesh = &mesh;
  object.center_world = Eigen::Vector3d(x, y, 0.06);
  object.T_world_object.translation() = object.center_world;
  object.T_world_object.linear() =
      Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  object.radius = 0.5 * mesh.Diameter();
  return object;
}

// Of each object: pixels that it wins in the sensor's whole image, by those it would have alone in
// an image three times as large.
std::vector<double> VisibleShares(const std::vector<PlannedObject>& objects, const Pose& view) {
  const CameraModel camera = CameraModel().Scaled(0.5);
  CameraModel wide = camera;
  wide.width *= 3;
  wide.height *= 3;
  wide.cx += camera.width;
  wide.cy += camera.height;
  const auto count = [&](std::span<const uint32_t> ids, uint32_t id) {
    return static_cast<double>(std::count(ids.begin(), ids.end(), id));
  };
  DepthRasterizer all(camera);
  for (size_t i = 0; i < objects.size(); ++i) {
    all.Draw(
        *objects[i].mesh, view.inverse() * objects[i].T_world_object, static_cast<uint32_t>(i));
  }
  std::vector<double> shares;
  for (size_t i = 0; i < objects.size(); ++i) {
    DepthRasterizer alone(wide);
    alone.Draw(*objects[i].mesh, view.inverse() * objects[i].T_world_object, 0);
    shares.push_back(count(all.mesh_ids(), static_cast<uint32_t>(i)) / count(alone.mesh_ids(), 0));
  }
  return shares;
}

TEST(Occlusion, SharesAreThoseOfTheWholeImage) {
  const TriangleMesh small = BoxMesh({0.06F, 0.08F, 0.12F});
  const TriangleMesh large = BoxMesh({0.15F, 0.05F, 0.12F});
  Rng rng(6);
  int num_hidden = 0;
  for (int trial = 0; trial < 6; ++trial) {
    std::vector<PlannedObject> objects;
    for (int i = 0; i < 4; ++i) {
      // Some so far out that they leave the image of some views.
      objects.push_back(Standing(i % 2 == 0 ? small : large,
                                 0.12 * i - 0.15 + 0.4 * (trial == 5),
                                 rng.Uniform(-0.08, 0.08),
                                 rng.Uniform(0.0, kPi)));
    }
    const std::vector<Pose> views = ManyViews(8);
    const std::vector<Visibility> found = FindOcclusion({}, views, objects);
    ASSERT_EQ(found.size(), 32U);
    for (size_t view = 0; view < views.size(); ++view) {
      const std::vector<double> expected = VisibleShares(objects, views[view]);
      for (size_t i = 0; i < 4; ++i) {
        const Visibility& one = found[4 * view + i];
        EXPECT_NEAR(one.share, expected[i], 0.06) << trial << " " << view << " " << i;
        EXPECT_EQ(one.share == 1.0, one.occluder == Visibility::kNone);
        EXPECT_NE(one.occluder, static_cast<int>(i));
        num_hidden += one.share < 0.9 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(num_hidden, 20);
}

TEST(Occlusion, NamesWhatHides) {
  const TriangleMesh box = BoxMesh({0.08F, 0.08F, 0.1F});
  const TriangleMesh wall = BoxMesh({0.02F, 0.5F, 0.5F});
  const std::vector<PlannedObject> objects = {Standing(box, 0.0, 0.0, 0.0),
                                              Standing(wall, 0.3, 0.0, 0.0)};
  const Eigen::Vector3d center(0.0, 0.0, 0.06);
  const std::vector<Pose> views = {LookAt(Eigen::Vector3d(0.8, 0.0, 0.1), center),
                                   LookAt(Eigen::Vector3d(-0.8, 0.0, 0.1), center),
                                   LookAt(Eigen::Vector3d(0.0, 0.8, -0.3), center),
                                   LookAt(Eigen::Vector3d(0.0, 0.8, 0.1), -0.8 * center)};
  OcclusionParameters parameters;
  parameters.table_height = 0.0;
  const std::vector<Visibility> found = FindOcclusion(parameters, views, objects);
  EXPECT_EQ(found[0], (Visibility{0.0, 1}));
  EXPECT_EQ(found[2], Visibility{});
  EXPECT_EQ(found[4], (Visibility{0.0, Visibility::kTable}));
  EXPECT_EQ(found[5], (Visibility{0.0, Visibility::kTable}));
  EXPECT_EQ(found[6], Visibility{});
  parameters.table_height.reset();
  EXPECT_GT(FindOcclusion(parameters, views, objects)[4].share, 0.0);

  const Pose away = LookAt(Eigen::Vector3d(0.8, 0.8, 0.1), Eigen::Vector3d(2.0, 2.0, 0.1));
  const Pose beside = LookAt(Eigen::Vector3d(0.0, 0.8, 0.1), Eigen::Vector3d(0.8, 0.0, 0.1));
  for (const Pose& view : {away, beside}) {
    EXPECT_EQ(FindOcclusion({}, std::span(&view, 1), std::span(objects).first(1))[0],
              (Visibility{0.0, Visibility::kImage}));
  }
}

TEST(Occlusion, WithoutAMeshNothingIsHidden) {
  std::vector<PlannedObject> objects(2);
  objects[1].center_world = Eigen::Vector3d(0.1, 0.0, 0.0);
  for (const Visibility& one : FindOcclusion({}, ManyViews(50), objects)) {
    EXPECT_EQ(one, Visibility{});
  }
}

TEST(Occlusion, WhatIsHardlyVisibleIsNotFound) {
  EXPECT_EQ(UnhiddenFactor({1.0, Visibility::kNone}), 1.0);
  EXPECT_EQ(UnhiddenFactor({0.75, 0}), 1.0);
  EXPECT_NEAR(UnhiddenFactor({0.5, 0}), 0.5, 1e-12);
  EXPECT_EQ(UnhiddenFactor({0.25, 0}), 0.0);
  EXPECT_EQ(UnhiddenFactor({0.0, 0}), 0.0);
}

TEST(OcclusionCache, KeepsNothingThatHasChanged) {
  const TriangleMesh box = BoxMesh({0.08F, 0.08F, 0.1F});
  std::vector<PlannedObject> objects = {Standing(box, 0.0, 0.0, 0.0), Standing(box, 0.1, 0.0, 0.3)};
  std::vector<Pose> views = ManyViews(30);
  OcclusionCache cache({});
  const auto expect_right = [&] {
    const std::span<const Visibility> found = cache.Find(views, objects);
    const std::vector<Visibility> expected = FindOcclusion({}, views, objects);
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
  };
  expect_right();
  expect_right();
  const Visibility* before = cache.Find(views, objects).data();
  EXPECT_EQ(cache.Find(views, objects).data(), before);
  objects[1] = Standing(box, 0.12, 0.02, 0.3);
  expect_right();
  views = ManyViews(20);
  expect_right();
  objects.pop_back();
  expect_right();
}

TEST(Occlusion, ParametersAreChecked) {
  OcclusionParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.table_height = NAN;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.camera.fx = 0.0;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
