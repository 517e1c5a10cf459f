// The spheres and circles of the viewer against formulas of another kind.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/so3_grid.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/sphere_renderer.h"
#include "tools/viewer/fiber_renderer.h"
#include "tools/viewer/orientation_samples.h"

namespace vantage {
namespace {

// Rodrigues' formula for the shortest rotation of a to b.
Eigen::Matrix3d Shortest(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d w = a.cross(b);
  Eigen::Matrix3d cross;
  cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return Eigen::Matrix3d::Identity() + cross + cross * cross / (1.0 + a.dot(b));
}

TEST(PlaceOf, IsTheRotatedVectorAndTheAngleThatItHides) {
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    const Eigen::Quaterniond reference = rng.Rotation();
    const Eigen::Vector3d v = rng.UnitVector();
    const FiberPlace place = PlaceOf(q, v, reference);
    const Eigen::Matrix3d R = q.toRotationMatrix();
    EXPECT_TRUE(place.direction.isApprox(R * v, 1e-9));
    const Eigen::Matrix3d R0 = reference.toRotationMatrix();
    const double toward = (R0 * v).dot(R * v);
    if (toward < -0.999) continue;  // Where the shortest way is not unique.
    // How far a direction across v is turned beyond where the reference's would be.
    const Eigen::Vector3d across = v.unitOrthogonal();
    const Eigen::Vector3d zero = Shortest(R0 * v, R * v) * R0 * across;
    const Eigen::Vector3d turned = R * across;
    const double angle = std::atan2(zero.cross(turned).dot(place.direction), zero.dot(turned));
    EXPECT_NEAR(std::remainder(place.angle - angle, 2.0 * std::numbers::pi), 0.0, 1e-6);
    EXPECT_GE(place.angle, -std::numbers::pi);
    EXPECT_LT(place.angle, std::numbers::pi);
  }
}

TEST(PlaceOf, SameForBothSignsAndZeroAtTheReference) {
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    const Eigen::Vector3d v = rng.UnitVector();
    EXPECT_NEAR(PlaceOf(q, v, q).angle, 0.0, 1e-7);
    const Eigen::Quaterniond minus(-q.w(), -q.x(), -q.y(), -q.z());
    const Eigen::Quaterniond reference = rng.Rotation();
    EXPECT_NEAR(std::remainder(PlaceOf(q, v, reference).angle - PlaceOf(minus, v, reference).angle,
                               2.0 * std::numbers::pi),
                0.0,
                1e-7);
    // A turn about where v points changes the angle alone.
    const Eigen::Quaterniond turned = ExpSo3(0.7 * (q * v)) * q;
    EXPECT_NEAR(PlaceOf(turned, v, q).angle, 0.7, 1e-7);
    EXPECT_TRUE(PlaceOf(turned, v, q).direction.isApprox(q * v, 1e-9));
  }
}

TEST(SamplesOf, LeavesOutCellsThatAreNoneAndSumsToOne) {
  const So3Grid grid(16);
  orientation_histogram_t histogram{};
  histogram.k = 16;
  const So3Grid::Cell cell = grid.CellOf(Eigen::Quaterniond::Identity());
  histogram.cell = {cell, -1, 2'000'000'000, 0, cell, cell};
  histogram.weight = {3.0F, 1.0F, 1.0F, 1.0F, std::nanf(""), -2.0F};
  histogram.num_cells = 6;
  const std::vector<OrientationSample> samples = SamplesOf(histogram);
  ASSERT_FALSE(grid.IsValid(0));
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_DOUBLE_EQ(samples[0].weight, 1.0);
  for (const int k : {0, 1, -5, 129, 2'000'000'000}) {
    histogram.k = k;
    EXPECT_TRUE(SamplesOf(histogram).empty());
  }
}

// Two orientations that the rotated vector can't tell apart.
std::vector<OrientationSample> HiddenPair(const Eigen::Vector3d& v, double angle) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()));
  return {{q, 0.6}, {ExpSo3(angle * (q * v)) * q, 0.4}};
}

TEST(FindSpots, CircleShowsWhatTheSphereHides) {
  const Eigen::Vector3d v = Eigen::Vector3d::Ones().normalized();
  std::vector<OrientationSample> samples = HiddenPair(v, 95.0 * kDegree);
  const Eigen::Quaterniond reference = samples[0].q;
  samples.push_back({ExpSo3(Eigen::Vector3d(1.5, 0, 0)) * reference, 0.1});
  const std::vector<FiberSpot> spots = FindSpots(samples, v, reference, 12.0 * kDegree, 4);
  ASSERT_EQ(spots.size(), 2U);
  EXPECT_TRUE(spots[0].direction.isApprox(reference * v, 1e-9));
  EXPECT_NEAR(spots[0].weight, 1.0, 1e-12);
  EXPECT_NEAR(spots[0].bins[18], 0.6, 1e-12);  // 0 to 10 degrees
  EXPECT_NEAR(spots[0].bins[27], 0.4, 1e-12);  // 90 to 100 degrees
  EXPECT_TRUE(FindSpots({}, v, reference, 0.2, 4).empty());
}

TEST(RenderFibers, ColorIsTheAngleAndGreyWhereSeveralMeet) {
  const Eigen::Vector3d v = Eigen::Vector3d::Ones().normalized();
  const std::vector<OrientationSample> pair = HiddenPair(v, 180.0 * kDegree);
  TwoHalves view;
  view.radius_px = 60;
  view.towards = pair[0].q * v + Eigen::Vector3d(0.0, 0.3, 0.0);
  const Eigen::Vector2d at = view.Project(pair[0].q * v);
  const auto color_at = [&](const std::vector<OrientationSample>& samples) {
    const RgbImage image = RenderFibers(samples, v, pair[0].q, view, {255, 255, 255});
    EXPECT_EQ(image.width, view.width());
    EXPECT_EQ(image.height, view.height());
    return PixelAt(image, static_cast<int>(at.x()), static_cast<int>(at.y()));
  };
  const auto chroma = [](Rgb c) { return std::max({c.r, c.g, c.b}) - std::min({c.r, c.g, c.b}); };
  const Rgb one = color_at({{pair[0].q, 1.0}});
  EXPECT_GT(chroma(one), 60);
  EXPECT_GT(one.r, one.g);  // Angle 0 is red.
  const Rgb other = color_at({{pair[1].q, 1.0}});
  EXPECT_GT(other.g, other.r);  // 180 degrees is opposite of it.
  const Rgb both = color_at({{pair[0].q, 0.5}, {pair[1].q, 0.5}});
  EXPECT_LT(chroma(both), 20);
}

TEST(TwoHalves, SamePlacesAsTheDensityPicture) {
  Rng rng(3);
  for (int i = 0; i < 10; ++i) {
    TwoHalves view;
    view.radius_px = 60;
    view.towards = rng.UnitVector();
    const Eigen::Vector3d direction = rng.UnitVector();
    if (std::abs(direction.dot(view.towards)) < 0.3) continue;  // At the rim it is on both.
    const SphereSample sample{direction.cast<float>(), 1.0F};
    SphereView density;
    density.radius_px = 60;
    density.towards = view.towards;
    const RgbImage image = RenderSphereDensity({&sample, 1}, density);
    ASSERT_EQ(image.width, view.width());
    const Eigen::Vector2d at = view.Project(direction);
    const Rgb color = PixelAt(
        image, static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
    EXPECT_LT(color.r, 90) << "expected the darkest blue at the sample";
  }
}

TEST(AngleColor, IsAsLightAllAround) {
  for (int degree = -180; degree < 180; degree += 5) {
    const Rgb c = AngleColor(degree * kDegree);
    const double luma = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    EXPECT_NEAR(luma, 145.0, 22.0) << degree;
  }
}

}  // namespace
}  // namespace vantage
