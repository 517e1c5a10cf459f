#include "perception/refinement/refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

constexpr double kFocal = 570.0;  // px
const TriangleMesh kMesh = MakeAsymmetric();
const DrawableMesh kDrawable(kMesh);
const ModelShape kShape{kDrawable, kMesh.SurfaceCentroid(), kMesh.Diameter(), kMesh.Diameter()};

// Seen from obliquely above, so that three kinds of faces show.
Pose RandomView(Rng& rng) {
  const double azimuth = rng.Uniform(0.0, 6.28);
  const double elevation = rng.Uniform(30.0, 60.0) * kDegree;
  const Eigen::Vector3d eye = 0.5 * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                                    std::cos(elevation) * std::sin(azimuth),
                                                    std::sin(elevation));
  return LookAt(eye, Eigen::Vector3d(0.05, 0.03, 0.03)).inverse();
}

Pose Disturbed(const Pose& T, double angle, double distance, Rng& rng) {
  const Eigen::Vector3d center = T * kMesh.SurfaceCentroid();
  Pose disturbed(Eigen::Translation3d(center + distance * rng.UnitVector()) *
                 ExpSo3(angle * rng.UnitVector()) * Eigen::Translation3d(-center));
  return disturbed * T;
}

double AngleBetween(const Pose& a, const Pose& b) {
  return GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear()));
}

TEST(NearestGrid, FindsTheNearestToWithinACube) {
  Rng rng(1);
  const std::vector<SurfacePoint> points = SampleSurface(kMesh, 300, rng);
  const double cell = 0.003;
  const double reach = 0.02;
  const NearestGrid grid(points, reach, cell);
  const double slack = cell * std::sqrt(3.0);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3f place(static_cast<float>(rng.Uniform(-0.05, 0.15)),
                                static_cast<float>(rng.Uniform(-0.05, 0.12)),
                                static_cast<float>(rng.Uniform(-0.05, 0.13)));
    double nearest = 1e9;
    for (const SurfacePoint& point : points) {
      nearest = std::min(nearest, static_cast<double>((point.position - place).norm()));
    }
    const uint32_t index = grid.Find(place);
    if (index == NearestGrid::kNone) {
      EXPECT_GT(nearest, reach - slack);
      continue;
    }
    ++found;
    const auto distance = static_cast<double>((grid.points()[index].position - place).norm());
    EXPECT_LE(distance, nearest + slack);
  }
  EXPECT_GT(found, 300);
  EXPECT_EQ(grid.Find({1e9F, 0.0F, 0.0F}), NearestGrid::kNone);
  EXPECT_EQ(grid.Find({std::nanf(""), 0.0F, 0.0F}), NearestGrid::kNone);
}

// The same lookups one by one and eight at a time.
TEST(NearestGrid, LanesFindWhatFindDoes) {
  Rng rng(11);
  const NearestGrid grid(SampleSurface(kMesh, 500, rng), 0.02, 0.004);
  for (int trial = 0; trial < 200; ++trial) {
    F8s<3> places{};
    for (int lane = 0; lane < kLanes; ++lane) {
      for (size_t i = 0; i < 3; ++i) {
        places[i][lane] = static_cast<float>(rng.Uniform(-0.05, 0.15));
      }
    }
    if (trial == 0) {
      places[0][0] = std::numeric_limits<float>::quiet_NaN();
      places[1][1] = std::numeric_limits<float>::infinity();
      places[2][2] = -1e30F;
    }
    F8s<3> position;
    F8s<3> normal;
    grid.FindLanes(places, &position, &normal);
    for (int lane = 0; lane < kLanes; ++lane) {
      const uint32_t index = grid.Find({places[0][lane], places[1][lane], places[2][lane]});
      const Eigen::Vector3f found(position[0][lane], position[1][lane], position[2][lane]);
      const Eigen::Vector3f its_normal(normal[0][lane], normal[1][lane], normal[2][lane]);
      if (index == NearestGrid::kNone) {
        EXPECT_EQ(its_normal.norm(), 0.0F);
      } else {
        EXPECT_EQ(found, grid.points()[index].position);
        EXPECT_EQ(its_normal, grid.points()[index].normal);
      }
    }
  }
}

// Points of the side that faces the camera, and their view.
struct Scene {
  Pose T_camera_object;
  std::vector<SurfacePoint> surface;
  ScenePoints points;

  explicit Scene(Rng& rng) : T_camera_object(RandomView(rng)) {
    for (const SurfacePoint& point : SampleSurface(kMesh, 500, rng)) {
      const Eigen::Vector3d p = T_camera_object * point.position.cast<double>();
      const Eigen::Vector3d n = T_camera_object.linear() * point.normal.cast<double>();
      if (n.dot(p) < 0.0) surface.push_back({p.cast<float>(), n.cast<float>()});
    }
    points.Assign(surface, kFocal, {});
  }
};

NearestGrid MakeGrid() {
  Rng rng(7);
  return {SampleSurface(kMesh, 4000, rng), 0.16 * kMesh.Diameter(), 0.02 * kMesh.Diameter()};
}

TEST(RefineCoarse, BringsVotedPosesIntoReachOfTheFineOne) {
  Rng rng(6);
  const NearestGrid grid = MakeGrid();
  int near = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Scene scene(rng);
    const Pose start = Disturbed(scene.T_camera_object,
                                 rng.Uniform(0.0, 12.0) * kDegree,
                                 rng.Uniform(0.0, 0.08) * kMesh.Diameter(),
                                 rng);
    const CoarselyRefined refined = RefineCoarse(grid, kShape, start, scene.points, {});
    const double distance =
        (refined.T_camera_object * kShape.center - scene.T_camera_object * kShape.center).norm();
    near += AngleBetween(refined.T_camera_object, scene.T_camera_object) < 4.0 * kDegree &&
                    distance < 0.03 * kMesh.Diameter()
                ? 1
                : 0;
  }
  EXPECT_GE(near, kTrials * 97 / 100);
}

TEST(RefineCoarse, ReturnsTheStartWhereNothingIsNear) {
  Rng rng(8);
  const NearestGrid grid = MakeGrid();
  const Scene scene(rng);
  Pose beside = scene.T_camera_object;
  beside.translation().x() += 1.0;
  const CoarselyRefined refined = RefineCoarse(grid, kShape, beside, scene.points, {});
  EXPECT_EQ(refined.pairs, 0);
  EXPECT_LT((refined.T_camera_object.matrix() - beside.matrix()).norm(), 1e-12);
  const CoarselyRefined without = RefineCoarse(grid, kShape, beside, ScenePoints(), {});
  EXPECT_EQ(without.pairs, 0);
}

TEST(ScenePoints, LeaveOutWhatIsNotFinite) {
  Rng rng(9);
  Scene scene(rng);
  const size_t size = scene.points.size();
  scene.surface[0].position.x() = std::numeric_limits<float>::quiet_NaN();
  scene.surface[1].normal.y() = std::numeric_limits<float>::infinity();
  scene.points.Assign(scene.surface, kFocal, {});
  EXPECT_EQ(scene.points.size(), size - 2);
  const CoarselyRefined refined =
      RefineCoarse(MakeGrid(), kShape, scene.T_camera_object, scene.points, {});
  EXPECT_TRUE(refined.T_camera_object.matrix().allFinite());
  EXPECT_GT(refined.pairs, 0);
}

TEST(RefinementParameters, RefuseValuesOutOfRange) {
  RefinementParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.coarse_reach_end = 0.5;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.final_points = 0;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.correlated_px = std::nan("");
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
