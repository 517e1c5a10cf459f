#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "perception/shot/correspondence_ransac.h"

namespace vantage {
namespace {

RansacParameters Parameters() {
  return {.min_distance = 0.02,
          .distance_tolerance = 0.004,
          .angle_tolerance = 12.0 * kDegree,
          .inlier_distance = 0.005,
          .probability = 0.999,
          .max_iterations = 100000,
          .max_hypotheses = 32};
}

SurfacePoint Moved(const Pose& T, const SurfacePoint& point) {
  return {(T * point.position.cast<double>()).cast<float>(),
          (T.linear() * point.normal.cast<double>()).cast<float>()};
}

SurfacePoint RandomPoint(Rng& rng) {
  return {Eigen::Vector3d(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1))
              .cast<float>(),
          rng.UnitVector().cast<float>()};
}

Pose RandomPose(Rng& rng) {
  Pose T(rng.Rotation());
  T.translation() = Eigen::Vector3d(rng.Uniform(-0.2, 0.2), rng.Uniform(-0.2, 0.2), 0.7);
  return T;
}

// Three points that meet all conditions, the target's moved by a random pose.
std::array<Correspondence, 3> GoodTriplet() {
  const std::array<Eigen::Vector3f, 3> places = {Eigen::Vector3f{0.0F, 0.0F, 0.0F},
                                                 Eigen::Vector3f{0.06F, 0.0F, 0.0F},
                                                 Eigen::Vector3f{0.01F, 0.05F, 0.0F}};
  Rng rng(3);
  const Pose T = RandomPose(rng);
  std::array<Correspondence, 3> triplet;
  for (uint32_t i = 0; i < 3; ++i) {
    const SurfacePoint match{places[i], Eigen::Vector3f::UnitZ()};
    triplet[i] = {i, Moved(T, match), match};
  }
  return triplet;
}

// Of `count` keypoints one correspondence each, the first `good` of them right under `T`.
std::vector<Correspondence> Mixed(const Pose& T, uint32_t count, uint32_t good, Rng& rng) {
  std::vector<Correspondence> all;
  for (uint32_t i = 0; i < count; ++i) {
    const SurfacePoint match = RandomPoint(rng);
    all.push_back({i, Moved(T, i < good ? match : RandomPoint(rng)), match});
  }
  return all;
}

double AngleTo(const Pose& a, const Pose& b) {
  return GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear()));
}

// Keypoints within reach of a motion, by the definition.
int CountInliers(const std::vector<Correspondence>& all, const Pose& T, const RansacParameters& p) {
  int count = 0;
  for (const Correspondence& pair : all) {
    const SurfacePoint moved = Moved(T, pair.match);
    const double angle =
        std::acos(std::clamp(static_cast<double>(moved.normal.dot(pair.query.normal)), -1.0, 1.0));
    count += (moved.position - pair.query.position).norm() <= p.inlier_distance &&
                     angle <= 2.0 * p.angle_tolerance
                 ? 1
                 : 0;
  }
  return count;
}

TEST(MeetsConditions, TakesATripletThatWasMoved) {
  EXPECT_TRUE(MeetsConditions(GoodTriplet(), Parameters()));
}

TEST(MeetsConditions, RefusesQueryPointsOnALine) {
  std::array<Correspondence, 3> triplet = GoodTriplet();
  // Matches on a line too, so that distances and angles agree.
  triplet[2].match.position = 0.5F * (triplet[0].match.position + triplet[1].match.position);
  triplet[2].query.position = 0.5F * (triplet[0].query.position + triplet[1].query.position);
  EXPECT_FALSE(MeetsConditions(triplet, Parameters()));
}

TEST(MeetsConditions, RefusesMatchPointsOnALine) {
  RansacParameters parameters = Parameters();
  parameters.distance_tolerance = 1.0;
  parameters.angle_tolerance = 4.0;
  std::array<Correspondence, 3> triplet = GoodTriplet();
  EXPECT_TRUE(MeetsConditions(triplet, parameters));
  triplet[2].match.position = 0.5F * (triplet[0].match.position + triplet[1].match.position);
  EXPECT_FALSE(MeetsConditions(triplet, parameters));
}

TEST(MeetsConditions, RefusesPointsNearerThanTheLeastDistance) {
  const std::array<Correspondence, 3> triplet = GoodTriplet();
  RansacParameters parameters = Parameters();
  // The shortest side is 0.051 m.
  parameters.min_distance = 0.0505;
  EXPECT_TRUE(MeetsConditions(triplet, parameters));
  parameters.min_distance = 0.0515;
  EXPECT_FALSE(MeetsConditions(triplet, parameters));
}

TEST(MeetsConditions, RefusesDistancesThatDiffer) {
  std::array<Correspondence, 3> triplet = GoodTriplet();
  for (Correspondence& pair : triplet) pair.match.position *= 1.05F;
  // A like triangle: all angles agree, the longest sides differ by 0.0035 m.
  RansacParameters parameters = Parameters();
  EXPECT_TRUE(MeetsConditions(triplet, parameters));
  parameters.distance_tolerance = 0.003;
  EXPECT_FALSE(MeetsConditions(triplet, parameters));
}

TEST(MeetsConditions, RefusesTrianglesWhoseAnglesDiffer) {
  std::array<Correspondence, 3> triplet = GoodTriplet();
  triplet[2].match.position.x() += 0.03F;  // In the plane: the normals' angles stay.
  RansacParameters parameters = Parameters();
  parameters.distance_tolerance = 1.0;
  EXPECT_FALSE(MeetsConditions(triplet, parameters));
  parameters.angle_tolerance = 60.0 * kDegree;
  EXPECT_TRUE(MeetsConditions(triplet, parameters));
}

TEST(MeetsConditions, RefusesNormalsWhoseAnglesDiffer) {
  const auto tilted = [](double angle) {
    std::array<Correspondence, 3> triplet = GoodTriplet();
    triplet[1].match.normal = Eigen::AngleAxisf(static_cast<float>(angle),
                                                Eigen::Vector3f(1.0F, 1.0F, 0.0F).normalized()) *
                              triplet[1].match.normal;
    return triplet;
  };
  EXPECT_TRUE(MeetsConditions(tilted(10.0 * kDegree), Parameters()));
  EXPECT_FALSE(MeetsConditions(tilted(14.0 * kDegree), Parameters()));
}

TEST(MeetsConditions, RefusesWhatIsNotFinite) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::array<Correspondence, 3> triplet = GoodTriplet();
    triplet[1].query.position.y() = bad;
    EXPECT_FALSE(MeetsConditions(triplet, Parameters()));
  }
}

TEST(RequiredIterations, FollowsFischlerAndBolles) {
  // At a half of inliers a triplet is right with 1/8: log(0.01) / log(7/8) = 34.5.
  EXPECT_EQ(RequiredIterations(0.125, 0.99, 1000), 35);
  EXPECT_EQ(RequiredIterations(0.125, 0.0, 1000), 1);
  EXPECT_EQ(RequiredIterations(1.0, 0.99, 1000), 1);
  EXPECT_EQ(RequiredIterations(0.0, 0.99, 1000), 1000);
  EXPECT_EQ(RequiredIterations(1e-12, 0.99, 1000), 1000);
  for (const double chance : {0.3, 0.01, 1e-3}) {
    const int draws = RequiredIterations(chance, 0.999, 1 << 30);
    EXPECT_GE(1.0 - std::pow(1.0 - chance, draws), 0.999);
    EXPECT_LT(1.0 - std::pow(1.0 - chance, draws - 1), 0.999);
  }
}

TEST(AlignMatches, GivesTheMotionBack) {
  Rng rng(11);
  for (int round = 0; round < 20; ++round) {
    const Pose T = RandomPose(rng);
    const std::vector<Correspondence> all = Mixed(T, 8, 8, rng);
    const Pose found = AlignMatches(all, 1e-4);
    EXPECT_LT(AngleTo(found, T), 1e-5);
    EXPECT_LT((found.translation() - T.translation()).norm(), 1e-6);
    EXPECT_NEAR(found.linear().determinant(), 1.0, 1e-9);
  }
}

TEST(CorrespondenceRansac, RecoversKnownShiftedAndInversePoses) {
  Rng rng(21);
  Pose shifted = Pose::Identity();
  shifted.translation() = Eigen::Vector3d(0.3, -0.2, 1.1);
  const Pose random = RandomPose(rng);
  for (const Pose& T : {Pose::Identity(), shifted, random, random.inverse()}) {
    const std::vector<Correspondence> all = Mixed(T, 60, 60, rng);
    CorrespondenceRansac ransac;
    const auto found = ransac.Run(all, Parameters(), rng);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().inliers, 60);
    EXPECT_LT(AngleTo(found.front().T_query_match, T), 1e-5);
    EXPECT_LT((found.front().T_query_match.translation() - T.translation()).norm(), 1e-5);
  }
}

TEST(CorrespondenceRansac, FindsAsManyInliersAsAllTripletsDo) {
  Rng rng(31);
  for (int round = 0; round < 5; ++round) {
    const Pose T = RandomPose(rng);
    constexpr uint32_t kCount = 30;
    const std::vector<Correspondence> all = Mixed(T, kCount, 9, rng);  // 70 % wrong.
    const RansacParameters parameters = Parameters();
    int most = 0;
    for (uint32_t a = 0; a < kCount; ++a) {
      for (uint32_t b = a + 1; b < kCount; ++b) {
        for (uint32_t c = b + 1; c < kCount; ++c) {
          const std::array<Correspondence, 3> triplet = {all[a], all[b], all[c]};
          if (!MeetsConditions(triplet, parameters)) continue;
          most = std::max(most, CountInliers(all, AlignMatches(triplet, 4e-4), parameters));
        }
      }
    }
    CorrespondenceRansac ransac;
    const auto found = ransac.Run(all, parameters, rng);
    ASSERT_FALSE(found.empty());
    EXPECT_GE(most, 9);
    EXPECT_GE(found.front().inliers, most);
    EXPECT_EQ(found.front().inliers, CountInliers(all, found.front().T_query_match, parameters));
    EXPECT_LT(AngleTo(found.front().T_query_match, T), 0.5 * kDegree);
  }
}

TEST(CorrespondenceRansac, CountsAKeypointOnce) {
  Rng rng(41);
  const Pose T = RandomPose(rng);
  std::vector<Correspondence> all;
  for (const Correspondence& pair : Mixed(T, 20, 20, rng)) {
    for (int copy = 0; copy < 3; ++copy) all.push_back(pair);
  }
  CorrespondenceRansac ransac;
  const auto found = ransac.Run(all, Parameters(), rng);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front().inliers, 20);
}

TEST(CorrespondenceRansac, GivesBothOfTwoObjects) {
  Rng rng(51);
  const std::array<Pose, 2> poses = {RandomPose(rng), RandomPose(rng)};
  std::vector<Correspondence> all = Mixed(poses[0], 30, 30, rng);
  for (Correspondence pair : Mixed(poses[1], 20, 20, rng)) {
    pair.keypoint += 30;
    all.push_back(pair);
  }
  RansacParameters parameters = Parameters();
  parameters.probability = 0.9999999;
  CorrespondenceRansac ransac;
  const auto found = ransac.Run(all, parameters, rng);
  ASSERT_GE(found.size(), 2U);
  EXPECT_LT(AngleTo(found[0].T_query_match, poses[0]), 1e-4);
  EXPECT_LT(AngleTo(found[1].T_query_match, poses[1]), 1e-4);
  for (size_t i = 1; i < found.size(); ++i) EXPECT_LE(found[i].inliers, found[i - 1].inliers);
}

TEST(CorrespondenceRansac, EndsEarlyWhenMostAgree) {
  Rng rng(61);
  const Pose T = RandomPose(rng);
  CorrespondenceRansac ransac;
  ransac.Run(Mixed(T, 100, 90, rng), Parameters(), rng);
  const int easy = ransac.iterations();
  ransac.Run(Mixed(T, 100, 10, rng), Parameters(), rng);
  EXPECT_LT(4 * easy, ransac.iterations());
}

TEST(CorrespondenceRansac, IsTheSameForTheSameState) {
  Rng rng(71);
  const std::vector<Correspondence> all = Mixed(RandomPose(rng), 80, 20, rng);
  CorrespondenceRansac first;
  CorrespondenceRansac second;
  Rng one(5);
  Rng two(5);
  second.Run(Mixed(Pose::Identity(), 30, 30, rng), Parameters(), rng);  // Leaves nothing behind.
  const auto a = first.Run(all, Parameters(), one);
  const auto b = second.Run(all, Parameters(), two);
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].inliers, b[i].inliers);
    EXPECT_EQ(a[i].T_query_match.matrix(), b[i].T_query_match.matrix());
  }
}

TEST(CorrespondenceRansac, GivesNothingWithoutTriplets) {
  Rng rng(81);
  CorrespondenceRansac ransac;
  EXPECT_TRUE(ransac.Run({}, Parameters(), rng).empty());
  EXPECT_TRUE(ransac.Run(Mixed(Pose::Identity(), 2, 2, rng), Parameters(), rng).empty());
  const std::vector<Correspondence> equal(50, Mixed(Pose::Identity(), 1, 1, rng).front());
  EXPECT_TRUE(ransac.Run(equal, Parameters(), rng).empty());
  std::vector<Correspondence> broken = Mixed(Pose::Identity(), 50, 50, rng);
  for (Correspondence& pair : broken) {
    pair.query.position.x() = std::numeric_limits<float>::quiet_NaN();
  }
  EXPECT_TRUE(ransac.Run(broken, Parameters(), rng).empty());
}

}  // namespace
}  // namespace vantage
