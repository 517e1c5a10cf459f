#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "perception/ppf/pair_features.h"
#include "perception/ppf/ppf_table.h"
#include "perception/ppf/ppf_voting.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

SurfacePoint Point(const Eigen::Vector3f& position, const Eigen::Vector3f& normal) {
  return {position, normal.normalized()};
}

SurfacePoint Moved(const SurfacePoint& point, const Pose& T) {
  return {(T * point.position.cast<double>()).cast<float>(),
          (T.linear() * point.normal.cast<double>()).cast<float>()};
}

Pose RandomPose(Rng& rng) {
  Pose T = Pose(rng.Rotation());
  T.translation() = 0.5 * rng.UnitVector() + Eigen::Vector3d(0.0, 0.0, 1.0);
  return T;
}

std::vector<SurfacePoint> Samples(size_t count, uint64_t seed = 1) {
  Rng rng(seed);
  return SampleSurface(MakeAsymmetric(), count, rng);
}

const double kDiameter = MakeAsymmetric().Diameter();

PpfTable Trained(const PpfTableParameters& parameters = {}) {
  Result<PpfTable> table = PpfTable::Train(Samples(3000), kDiameter, parameters);
  EXPECT_TRUE(table.ok());
  return std::move(table).value();
}

// As tables and votes see them.
struct Pair {
  PointPairFeature feature;
  float turn;
};
Pair PairOf(const SurfacePoint& first, const SurfacePoint& second) {
  SurfaceLanes lanes;
  lanes.Assign(std::span(&second, 1));
  PairFeatures f;
  ComputePairFeatures(first, lanes, &f);
  return {{f.distance[0], f.angle_normal1[0], f.angle_normal2[0], f.angle_normals[0]}, f.turn[0]};
}

TEST(PointPairFeature, HasValuesOfEquation1) {
  const PointPairFeature feature =
      ComputePointPairFeature(Point({0, 0, 0}, {0, 0, 1}), Point({3, 0, 4}, {1, 0, 0}));
  EXPECT_FLOAT_EQ(feature.distance, 5.0F);
  EXPECT_FLOAT_EQ(feature.angle_normal1, std::acos(0.8F));
  EXPECT_FLOAT_EQ(feature.angle_normal2, std::acos(0.6F));
  EXPECT_FLOAT_EQ(feature.angle_normals, std::numbers::pi_v<float> / 2.0F);
}

TEST(PointPairFeature, IsInvariantUnderRigidMotion) {
  Rng rng(2);
  for (int i = 0; i < 200; ++i) {
    const SurfacePoint a = Point(rng.UnitVector().cast<float>(), rng.UnitVector().cast<float>());
    const SurfacePoint b = Point(rng.UnitVector().cast<float>(), rng.UnitVector().cast<float>());
    const Pose T = RandomPose(rng);
    const PointPairFeature before = ComputePointPairFeature(a, b);
    const PointPairFeature after = ComputePointPairFeature(Moved(a, T), Moved(b, T));
    EXPECT_NEAR(before.distance, after.distance, 1e-5);
    EXPECT_NEAR(before.angle_normal1, after.angle_normal1, 2e-3);
    EXPECT_NEAR(before.angle_normal2, after.angle_normal2, 2e-3);
    EXPECT_NEAR(before.angle_normals, after.angle_normals, 2e-3);
  }
}

TEST(PointPairFeature, OfCoincidentPointsIsFinite) {
  const SurfacePoint a = Point({1, 2, 3}, {0, 0, 1});
  const PointPairFeature feature = ComputePointPairFeature(a, a);
  EXPECT_EQ(feature.distance, 0.0F);
  EXPECT_EQ(feature.angle_normal1, 0.0F);
}

TEST(PairFeatures, AreThoseOfSinglePairs) {
  Rng rng(11);
  std::vector<SurfacePoint> points;
  for (int i = 0; i < 500; ++i) {
    points.push_back(Point(0.2F * rng.UnitVector().cast<float>(), rng.UnitVector().cast<float>()));
  }
  points.push_back({points[0].position + 0.1F * points[0].normal, points[0].normal});
  points.push_back({points[0].position - 0.1F * points[0].normal, -points[0].normal});
  SurfaceLanes lanes;
  lanes.Assign(points);
  PairFeatures found;
  ComputePairFeatures(points[0], lanes, &found);
  const Eigen::Isometry3f T = AlignToXAxis(points[0]);
  for (size_t i = 0; i < points.size(); ++i) {
    const PointPairFeature expected = ComputePointPairFeature(points[0], points[i]);
    EXPECT_NEAR(found.distance[i], expected.distance, 1e-6F);
    // The arc cosine amplifies what is rounded near 0 and pi.
    EXPECT_NEAR(found.angle_normal1[i], expected.angle_normal1, 2e-3F) << i;
    EXPECT_NEAR(found.angle_normal2[i], expected.angle_normal2, 2e-3F) << i;
    EXPECT_NEAR(found.angle_normals[i], expected.angle_normals, 2e-3F) << i;
    if (i == 0 || i >= 500) continue;  // On the axis there is no turn.
    const float turn = AngleAboutX(T, points[i].position);
    EXPECT_NEAR(std::remainder(found.turn[i] - turn, 2.0F * std::numbers::pi_v<float>), 0.0F, 1e-3F)
        << i;
  }
}

TEST(AlignToXAxis, BringsPointToOriginAndNormalOntoX) {
  Rng rng(3);
  std::vector<Eigen::Vector3f> normals = {
      {1, 0, 0}, {-1, 0, 0}, {-1, 1e-3F, 0}, {-1, 1e-6F, 1e-6F}, {0, 1, 0}};
  for (int i = 0; i < 100; ++i) normals.push_back(rng.UnitVector().cast<float>());
  for (const Eigen::Vector3f& normal : normals) {
    const SurfacePoint point = Point({0.3F, -0.2F, 0.9F}, normal);
    const Eigen::Isometry3f T = AlignToXAxis(point);
    EXPECT_LT((T * point.position).norm(), 1e-5F);
    EXPECT_LT((T.linear() * point.normal - Eigen::Vector3f::UnitX()).norm(), 1e-2F);
    EXPECT_LT((T.linear() * T.linear().transpose() - Eigen::Matrix3f::Identity()).norm(), 1e-3F);
    EXPECT_NEAR(T.linear().determinant(), 1.0F, 1e-3F);
  }
}

TEST(PoseFromAlignment, IsThePoseOfThePairsThatAgree) {
  Rng rng(4);
  const std::vector<SurfacePoint> model = Samples(20);
  for (size_t i = 0; i + 1 < model.size(); ++i) {
    const Pose T = RandomPose(rng);
    const SurfacePoint scene_first = Moved(model[i], T);
    const SurfacePoint scene_second = Moved(model[i + 1], T);
    const double turn =
        static_cast<double>(AngleAboutX(AlignToXAxis(model[i]), model[i + 1].position)) -
        static_cast<double>(AngleAboutX(AlignToXAxis(scene_first), scene_second.position));
    const Pose found = PoseFromAlignment(scene_first, model[i], turn);
    EXPECT_LT((found.translation() - T.translation()).norm(), 1e-4);
    EXPECT_LT(GeodesicAngle(Eigen::Quaterniond(found.linear()), Eigen::Quaterniond(T.linear())),
              1e-3);
  }
}

TEST(ThinSamples, KeepsDistanceUnlessNormalsDiffer) {
  const std::vector<SurfacePoint> samples = Samples(2000);
  const double distance = 0.01;
  const double angle = 30.0 * kDegree;
  const std::vector<SurfacePoint> kept = ThinSamples(samples, distance, angle, 10000);
  const auto is_near = [&](const SurfacePoint& a, const SurfacePoint& b) {
    return (a.position - b.position).norm() < static_cast<float>(distance) &&
           a.normal.dot(b.normal) > static_cast<float>(std::cos(angle));
  };
  for (size_t i = 0; i < kept.size(); ++i) {
    for (size_t j = 0; j < i; ++j) EXPECT_FALSE(is_near(kept[i], kept[j]));
  }
  for (const SurfacePoint& sample : samples) {
    EXPECT_TRUE(std::any_of(kept.begin(), kept.end(), [&](const SurfacePoint& other) {
      return is_near(sample, other) || (sample.position == other.position);
    }));
  }
  EXPECT_EQ(ThinSamples(samples, distance, angle, 10).size(), 10U);
}

TEST(PpfTable, HoldsEveryPairOnceUnderItsKey) {
  PpfTableParameters parameters;
  parameters.sample_distance = 0.1;
  const PpfTable table = Trained(parameters);
  const auto points = table.points();
  size_t found = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t j = 0; j < points.size(); ++j) {
      if (i == j) continue;
      const Pair pair = PairOf(points[i], points[j]);
      const PpfTable::Entry expected{static_cast<uint16_t>(i), QuantizeTurn(pair.turn)};
      const auto cell = table.Lookup(table.Quantize(pair.feature));
      EXPECT_NE(std::find(cell.begin(), cell.end(), expected), cell.end());
      ++found;
    }
  }
  EXPECT_EQ(table.num_entries(), found);
}

TEST(PpfTable, LooksUpNothingOutside) {
  const PpfTable table = Trained();
  EXPECT_TRUE(table.Lookup({-1, 0, 0, 0}).empty());
  EXPECT_TRUE(table.Lookup({1000, 0, 0, 0}).empty());
  EXPECT_TRUE(table.Lookup({0, 15, 0, 0}).empty());
  EXPECT_TRUE(table.Lookup({0, 0, 0, -1}).empty());
}

TEST(PpfTable, RefusesBadInput) {
  EXPECT_FALSE(PpfTable::Train({}, kDiameter, {}).ok());
  EXPECT_FALSE(PpfTable::Train(Samples(100), 0.0, {}).ok());
  EXPECT_FALSE(PpfTable::Train(Samples(100), std::nan(""), {}).ok());
  std::vector<SurfacePoint> samples = Samples(100);
  samples[7].position.x() = std::nanf("");
  EXPECT_FALSE(PpfTable::Train(samples, kDiameter, {}).ok());
  PpfTableParameters parameters;
  parameters.angle_step_deg = 0.0;
  EXPECT_NE(PpfTable::Train(Samples(100), kDiameter, parameters).error().message.find("angle_step"),
            std::string::npos);
}

TEST(VotePoses, FindsTheWholeModelInAnyPose) {
  const PpfTable table = Trained();
  const Eigen::Vector3d center = MakeAsymmetric().SurfaceCentroid();
  Rng rng(6);
  for (int trial = 0; trial < 10; ++trial) {
    const Pose T = RandomPose(rng);
    std::vector<SurfacePoint> scene;
    for (const SurfacePoint& sample : ThinSamples(Samples(3000, 20), 0.05 * kDiameter, 0.5, 1000)) {
      scene.push_back(Moved(sample, T));
    }
    const std::vector<PoseHypothesis> found = VotePoses(table, scene, center, {}, rng);
    ASSERT_FALSE(found.empty());
    EXPECT_LT((found[0].T_camera_object * center - T * center).norm(), 0.05 * kDiameter);
    EXPECT_LT(GeodesicAngle(Eigen::Quaterniond(found[0].T_camera_object.linear()),
                            Eigen::Quaterniond(T.linear())),
              12.0 * kDegree);
    for (size_t i = 1; i < found.size(); ++i) EXPECT_LE(found[i].votes, found[i - 1].votes);
  }
}

TEST(VotePoses, SurvivesDegenerateScenes) {
  const PpfTable table = Trained();
  Rng rng(7);
  EXPECT_TRUE(VotePoses(table, {}, Eigen::Vector3d::Zero(), {}, rng).empty());
  const std::vector<SurfacePoint> one = {Point({0, 0, 1}, {0, 0, -1})};
  EXPECT_TRUE(VotePoses(table, one, Eigen::Vector3d::Zero(), {}, rng).empty());
  const std::vector<SurfacePoint> same(50, one[0]);
  for (const PoseHypothesis& hypothesis :
       VotePoses(table, same, Eigen::Vector3d::Zero(), {}, rng)) {
    EXPECT_TRUE(hypothesis.T_camera_object.matrix().allFinite());
  }
}

TEST(ClusterPoses, AveragesWhatIsNearAndKeepsTheRestApart) {
  const auto pose = [](double angle, double x) {
    Pose T(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    T.translation().x() = x;
    return T;
  };
  const std::vector<PoseHypothesis> clusters = ClusterPoses({{pose(0.0, 0.0), 3.0},
                                                             {pose(2.0, 0.0), 4.0},
                                                             {pose(0.1, 0.003), 1.0},
                                                             {pose(0.0, 0.5), 2.0}},
                                                            Eigen::Vector3d::Zero(),
                                                            0.01,
                                                            0.2,
                                                            10);
  ASSERT_EQ(clusters.size(), 3U);
  // Two of 4 votes; the sort is stable, so the one that was founded first comes first.
  EXPECT_DOUBLE_EQ(clusters[0].votes, 4.0);
  EXPECT_NEAR(clusters[1].T_camera_object.translation().x(), 0.00075, 1e-9);
  EXPECT_NEAR(Eigen::AngleAxisd(clusters[1].T_camera_object.linear()).angle(), 0.025, 1e-3);
  EXPECT_DOUBLE_EQ(clusters[2].votes, 2.0);
}

class PpfFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }
  std::string Read() const {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void Write(const std::string& bytes) const {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  }
  const fs::path folder =
      fs::temp_directory_path() / ("vantage_ppf_test_" + std::to_string(::getpid()));
  const fs::path file = folder / "ppf.bin";
};

TEST_F(PpfFile, ComesBackAsItWas) {
  const PpfTable table = Trained();
  ASSERT_TRUE(table.Save(file, 42).ok());
  const Result<PpfTable> loaded = PpfTable::Load(file, 42);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message;
  EXPECT_EQ(loaded->parameters(), table.parameters());
  EXPECT_EQ(loaded->num_entries(), table.num_entries());
  ASSERT_EQ(loaded->points().size(), table.points().size());
  for (size_t i = 0; i < table.points().size(); ++i) {
    EXPECT_EQ(loaded->points()[i].position, table.points()[i].position);
  }
  for (int i = 0; i < 15; ++i) {
    const PpfTable::Bins bins = {i, 7, i, 3};
    const auto a = table.Lookup(bins);
    const auto b = loaded->Lookup(bins);
    EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

TEST_F(PpfFile, OfAnotherMeshOrAbsentIsRefused) {
  EXPECT_EQ(PpfTable::Load(file, 42).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(Trained().Save(file, 42).ok());
  EXPECT_EQ(PpfTable::Load(file, 43).error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(Trained().Save(folder / "absent" / "ppf.bin", 42).ok());
}

TEST_F(PpfFile, DamagedIsRefused) {
  PpfTableParameters parameters;
  parameters.sample_distance = 0.2;
  ASSERT_TRUE(Trained(parameters).Save(file, 42).ok());
  const std::string whole = Read();
  for (size_t length = 0; length < whole.size(); length += 1 + length / 2) {
    Write(whole.substr(0, length));
    EXPECT_FALSE(PpfTable::Load(file, 42).ok()) << length;
  }
  Write(whole + "x");
  EXPECT_FALSE(PpfTable::Load(file, 42).ok());
  Rng rng(8);
  for (int i = 0; i < 400; ++i) {
    std::string damaged = whole;
    // Every byte of the header, then any.
    const size_t at =
        i < 72 ? static_cast<size_t>(i) : rng.Below(static_cast<uint32_t>(damaged.size()));
    damaged[at] = static_cast<char>(damaged[at] ^ static_cast<char>(1U << rng.Below(8)));
    Write(damaged);
    EXPECT_FALSE(PpfTable::Load(file, 42).ok()) << at;
  }
}

}  // namespace
}  // namespace vantage
