#include "perception/ppf/ppf_voting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

PpfTable CoarseTable() {
  PpfTableParameters parameters;
  parameters.sample_distance = 0.14;
  Rng rng(1);
  const TriangleMesh mesh = MakeAsymmetric();
  return PpfTable::Train(SampleSurface(mesh, 3000, rng), mesh.Diameter(), parameters).value();
}

std::vector<SurfacePoint> MovedSamples(size_t count, uint64_t seed) {
  Rng rng(seed);
  Pose T(rng.Rotation());
  T.translation() = Eigen::Vector3d(0.1, -0.2, 0.9);
  std::vector<SurfacePoint> scene;
  for (const SurfacePoint& sample : SampleSurface(MakeAsymmetric(), count, rng)) {
    scene.push_back({(T * sample.position.cast<double>()).cast<float>(),
                     (T.linear() * sample.normal.cast<double>()).cast<float>()});
  }
  return scene;
}

struct Pair {
  PointPairFeature feature;
  uint16_t turn;
};

Pair PairOf(const SurfacePoint& first, const SurfacePoint& second) {
  SurfaceLanes lanes;
  lanes.Assign(std::span(&second, 1));
  PairFeatures f;
  ComputePairFeatures(first, lanes, &f);
  return {{f.distance[0], f.angle_normal1[0], f.angle_normal2[0], f.angle_normals[0]},
          QuantizeTurn(f.turn[0])};
}

// True where a model pair's bins are a scene pair's, or their neighbors beyond a border that is
// near.
bool Agrees(const PpfTable& table,
            const PointPairFeature& scene,
            const PpfTable::Bins& model,
            double spread) {
  const auto scaled = table.Scale(scene);
  const PpfTable::Bins own = table.Quantize(scene);
  for (size_t i = 0; i < 4; ++i) {
    const float within = scaled[i] - static_cast<float>(own[i]);
    const bool below = within < static_cast<float>(spread);
    const bool above = within > 1.0F - static_cast<float>(spread);
    const int difference = model[i] - own[i];
    if (difference != 0 && !(difference == -1 && below) && !(difference == 1 && above)) {
      return false;
    }
  }
  return true;
}

// Counts by the definition: all scene pairs against all model pairs.
std::vector<int> BruteForceVotes(const PpfTable& table,
                                 std::span<const SurfacePoint> scene,
                                 size_t reference,
                                 const PpfVotingParameters& parameters) {
  const auto points = table.points();
  const auto bins = static_cast<size_t>(parameters.turn_bins);
  std::vector<int> counts(points.size() * bins, 0);
  for (size_t i = 0; i < points.size(); ++i) {
    for (size_t j = 0; j < points.size(); ++j) {
      if (i == j) continue;
      const Pair known = PairOf(points[i], points[j]);
      const PpfTable::Bins known_bins = table.Quantize(known.feature);
      for (const SurfacePoint& other : scene) {
        if (other.position == scene[reference].position) continue;
        const Pair seen = PairOf(scene[reference], other);
        if (!Agrees(table, seen.feature, known_bins, parameters.spread)) continue;
        const auto turn = static_cast<uint16_t>(known.turn - seen.turn);
        ++counts[i * bins + turn * bins / 65536];
      }
    }
  }
  return counts;
}

std::vector<int> Counts(const PpfVoting& voting, size_t points, size_t bins) {
  std::vector<int> counts;
  for (size_t i = 0; i < points * bins; ++i) counts.push_back(voting.count(i / bins, i % bins));
  return counts;
}

TEST(PpfVoting, CountsEqualBruteForceOverAllModelPairs) {
  const PpfTable table = CoarseTable();
  std::vector<SurfacePoint> scene = MovedSamples(30, 9);
  scene.push_back({Eigen::Vector3f(5.0F, 5.0F, 5.0F), Eigen::Vector3f::UnitZ()});  // Too far.
  scene.push_back(scene.front());  // The same place twice.
  SurfaceLanes lanes;
  lanes.Assign(scene);
  PpfVoting voting;
  for (const double spread : {0.0, 0.2, 0.5}) {
    for (const int turn_bins : {30, 7}) {
      if (turn_bins == 7 && spread != 0.2) continue;
      PpfVotingParameters parameters;
      parameters.spread = spread;
      parameters.turn_bins = turn_bins;
      parameters.votes_per_reference = 30000;
      for (const size_t reference : {size_t{0}, size_t{17}, size_t{30}}) {
        voting.Accumulate(table, lanes, reference, parameters);
        const std::vector<int> expected = BruteForceVotes(table, scene, reference, parameters);
        EXPECT_EQ(Counts(voting, table.points().size(), static_cast<size_t>(turn_bins)), expected);
        const bool is_too_far = reference == 30;
        EXPECT_EQ(*std::max_element(expected.begin(), expected.end()) == 0, is_too_far);
      }
    }
  }
}

TEST(PpfVoting, CastsNoMoreVotesThanAllowedAndThoseAreOfAll) {
  const PpfTable table = CoarseTable();
  SurfaceLanes lanes;
  lanes.Assign(MovedSamples(80, 3));
  PpfVotingParameters all;
  all.votes_per_reference = 30000;
  PpfVotingParameters few;
  few.votes_per_reference = 100;
  PpfVoting voting;
  const size_t points = table.points().size();
  voting.Accumulate(table, lanes, 5, all);
  const std::vector<int> whole = Counts(voting, points, 30);
  voting.Accumulate(table, lanes, 5, few);
  const std::vector<int> part = Counts(voting, points, 30);
  int sum = 0;
  for (size_t i = 0; i < whole.size(); ++i) {
    EXPECT_LE(part[i], whole[i]);
    sum += part[i];
  }
  EXPECT_EQ(sum, 100);
}

TEST(PpfVoting, PeaksAreTheBestRowsByTheirCounts) {
  const PpfTable table = CoarseTable();
  SurfaceLanes lanes;
  lanes.Assign(MovedSamples(80, 4));
  const PpfVotingParameters parameters;
  PpfVoting voting;
  voting.Accumulate(table, lanes, 3, parameters);
  const size_t points = table.points().size();
  std::vector<int> best(points);
  for (size_t i = 0; i < points; ++i) {
    for (size_t bin = 0; bin < 30; ++bin) {
      best[i] = std::max(
          best[i],
          voting.count(i, bin) + voting.count(i, (bin + 1) % 30) + voting.count(i, (bin + 2) % 30));
    }
  }
  const auto peaks = voting.FindPeaks(7);
  ASSERT_EQ(peaks.size(), 7U);
  std::vector<int> sorted = best;
  std::sort(sorted.rbegin(), sorted.rend());
  std::vector<int> found;
  for (const PpfVoting::Peak& peak : peaks) {
    EXPECT_EQ(static_cast<int>(peak.votes), best[peak.model_point]);
    found.push_back(static_cast<int>(peak.votes));
  }
  std::sort(found.rbegin(), found.rend());
  EXPECT_TRUE(std::equal(found.begin(), found.end(), sorted.begin()));
}

TEST(PpfVoting, OfPointsInOnePlaceOrWithoutNumbersCountsNothing) {
  const PpfTable table = CoarseTable();
  const SurfacePoint one{Eigen::Vector3f(0.0F, 0.0F, 1.0F), Eigen::Vector3f(0.0F, 0.0F, -1.0F)};
  std::vector<SurfacePoint> scene(20, one);
  scene.push_back({Eigen::Vector3f::Constant(std::nanf("")), Eigen::Vector3f::UnitX()});
  scene.push_back({Eigen::Vector3f::Constant(INFINITY), Eigen::Vector3f::UnitX()});
  SurfaceLanes lanes;
  lanes.Assign(scene);
  PpfVoting voting;
  voting.Accumulate(table, lanes, 0, {});
  EXPECT_TRUE(voting.FindPeaks(10).empty());
}

TEST(PpfVotingParameters, OutOfRangeAreRefused) {
  PpfVotingParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.votes_per_reference = 40000;
  EXPECT_NE(parameters.Validate().error().message.find("votes_per_reference"), std::string::npos);
}

}  // namespace
}  // namespace vantage
