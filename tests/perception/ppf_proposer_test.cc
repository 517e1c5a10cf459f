#include "perception/ppf/ppf_proposer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/bus/fuzz/count_allocations.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

struct Known {
  TriangleMesh mesh;
  SymmetryGroup symmetry;
  Eigen::Vector3d center = mesh.SurfaceCentroid();
  double diameter = mesh.Diameter();
};

Known Asymmetric() { return {MakeAsymmetric(), SymmetryGroup::None()}; }

Known Carton() {
  return {MakeBox({-0.05F, -0.03F, -0.02F}, {0.05F, 0.03F, 0.02F}),
          SymmetryGroup::Dihedral(2, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX())};
}

PpfProposer Proposer(const std::vector<Known>& known) {
  std::vector<PpfProposer::Model> models;
  for (const Known& one : known) {
    Rng rng(1);
    models.push_back({PpfTable::Train(SampleSurface(one.mesh, 5000, rng), one.diameter, {}).value(),
                      one.center,
                      one.symmetry});
  }
  return PpfProposer(std::move(models), {});
}

Pose RandomPose(Rng& rng) {
  Pose T(rng.Rotation());
  T.translation() = 0.2 * rng.UnitVector() + Eigen::Vector3d(0.0, 0.0, 0.9);
  return T;
}

SurfacePoint Moved(const SurfacePoint& point, const Pose& T) {
  return {(T * point.position.cast<double>()).cast<float>(),
          (T.linear() * point.normal.cast<double>()).cast<float>()};
}

// What of a convex or nearly convex object faces the camera.
std::vector<SurfacePoint> Seen(const Known& known, const Pose& T, uint64_t seed) {
  Rng rng(seed);
  std::vector<SurfacePoint> scene;
  for (const SurfacePoint& sample :
       ThinSamples(SampleSurface(known.mesh, 5000, rng), 0.045 * known.diameter, 0.5, 2000)) {
    const SurfacePoint point = Moved(sample, T);
    if (point.normal.dot(point.position) < -0.15F * point.position.norm()) scene.push_back(point);
  }
  return scene;
}

bool IsNear(const Known& known, const Pose& a, const Pose& b, double degrees) {
  return (a * known.center - b * known.center).norm() < degrees / 150.0 * known.diameter &&
         SymmetricAngle(known.symmetry,
                        Eigen::Quaterniond(a.linear()),
                        Eigen::Quaterniond(b.linear())) < degrees * kDegree;
}

bool Holds(const Known& known, std::span<const PoseHypothesis> found, const Pose& T, double deg) {
  return std::any_of(found.begin(), found.end(), [&](const PoseHypothesis& hypothesis) {
    return IsNear(known, hypothesis.T_camera_object, T, deg);
  });
}

TEST(PpfProposer, HypothesesHoldTheTruthInAnyPose) {
  const std::vector<Known> known = {Asymmetric(), Carton()};
  PpfProposer proposer = Proposer(known);
  for (size_t model = 0; model < known.size(); ++model) {
    Rng rng(2);
    for (uint64_t trial = 0; trial < 30; ++trial) {
      const Pose T = RandomPose(rng);
      const auto found = proposer.Propose(model, Seen(known[model], T, trial), rng);
      EXPECT_TRUE(Holds(known[model], found, T, 15.0)) << model << " " << trial;
      // A place where the object isn't, to see that the check can fail.
      Pose shifted = T;
      shifted.translation().x() += 3.0 * known[model].diameter;
      EXPECT_FALSE(Holds(known[model], found, shifted, 15.0));
    }
  }
}

TEST(PpfProposer, HypothesesAreDistinctAndTheMostPromisingFirst) {
  const Known carton = Carton();
  PpfProposer proposer = Proposer({carton});
  const PpfVotingParameters parameters;
  Rng rng(3);
  const auto found = proposer.Propose(0, Seen(carton, RandomPose(rng), 1), rng);
  ASSERT_GE(found.size(), 2U);
  EXPECT_LE(found.size(), static_cast<size_t>(parameters.max_hypotheses));
  for (size_t i = 0; i < found.size(); ++i) {
    const Eigen::Matrix3d R = found[i].T_camera_object.linear();
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
    for (size_t j = 0; j < i; ++j) {
      EXPECT_LE(found[i].votes, found[j].votes);
      EXPECT_FALSE(IsNear(carton, found[i].T_camera_object, found[j].T_camera_object, 14.0));
    }
  }
}

TEST(PpfProposer, TurnsWithTheScene) {
  const Known known = Asymmetric();
  PpfProposer proposer = Proposer({known});
  Rng rng(4);
  for (int trial = 0; trial < 10; ++trial) {
    const Pose T = RandomPose(rng);
    // About the line of sight, so that the camera sees the same silhouette, and farther away.
    Pose motion(Eigen::AngleAxisd(rng.Uniform(-3.0, 3.0), Eigen::Vector3d::UnitZ()));
    std::vector<SurfacePoint> scene = Seen(known, T, 5);
    Rng first(6);
    const Pose before = proposer.Propose(0, scene, first)[0].T_camera_object;
    for (SurfacePoint& point : scene) point = Moved(point, motion);
    Rng second(6);
    EXPECT_TRUE(Holds(known, proposer.Propose(0, scene, second), motion * before, 15.0));
  }
}

TEST(PpfProposer, GivesTheSameAgainWhateverCameBefore) {
  const std::vector<Known> known = {Asymmetric(), Carton()};
  PpfProposer proposer = Proposer(known);
  Rng rng(7);
  const std::vector<SurfacePoint> scene = Seen(known[0], RandomPose(rng), 1);
  Rng first(8);
  const auto found = proposer.Propose(0, scene, first);
  const std::vector<PoseHypothesis> before(found.begin(), found.end());
  Rng other(9);
  proposer.Propose(1, Seen(known[1], RandomPose(rng), 2), other);
  Rng second(8);
  const auto again = proposer.Propose(0, scene, second);
  ASSERT_EQ(again.size(), before.size());
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(again[i].T_camera_object.matrix(), before[i].T_camera_object.matrix());
    EXPECT_EQ(again[i].votes, before[i].votes);
  }
}

TEST(PpfProposer, AllocatesNothingOnceWarm) {
  const Known known = Asymmetric();
  PpfProposer proposer = Proposer({known});
  Rng rng(10);
  const std::vector<SurfacePoint> scene = Seen(known, RandomPose(rng), 1);
  for (int i = 0; i < 3; ++i) proposer.Propose(0, scene, rng);
  const size_t before = BytesAllocated();
  Rng same(10);
  proposer.Propose(0, scene, same);
  EXPECT_EQ(BytesAllocated(), before);
}

TEST(PpfProposer, FindsNothingInDegenerateScenes) {
  const Known known = Asymmetric();
  PpfProposer proposer = Proposer({known});
  Rng rng(11);
  const SurfacePoint one{Eigen::Vector3f(0.0F, 0.0F, 1.0F), Eigen::Vector3f(0.0F, 0.0F, -1.0F)};
  SurfacePoint two = one;
  two.position.x() += 0.03F;
  EXPECT_TRUE(proposer.Propose(0, {}, rng).empty());
  EXPECT_TRUE(proposer.Propose(0, std::vector<SurfacePoint>{one}, rng).empty());
  EXPECT_TRUE(proposer.Propose(0, std::vector<SurfacePoint>{one, two}, rng).empty());
  EXPECT_TRUE(proposer.Propose(0, std::vector<SurfacePoint>(50, one), rng).empty());
  for (const float bad : {std::nanf(""), INFINITY, -INFINITY}) {
    std::vector<SurfacePoint> scene(50, one);
    for (SurfacePoint& point : scene) point.position.y() = bad;
    EXPECT_TRUE(proposer.Propose(0, scene, rng).empty());
    for (SurfacePoint& point : scene) point = {one.position, Eigen::Vector3f::Constant(bad)};
    EXPECT_TRUE(proposer.Propose(0, scene, rng).empty());
  }
}

TEST(PpfProposer, CopesWithNumbersOfAnySizeAndPointsWithoutNumbers) {
  const Known known = Asymmetric();
  PpfProposer proposer = Proposer({known});
  Rng rng(12);
  const Pose T = RandomPose(rng);
  std::vector<SurfacePoint> scene = Seen(known, T, 1);
  for (size_t i = 0; i < scene.size(); i += 10) scene[i].position.x() = std::nanf("");
  EXPECT_TRUE(Holds(known, proposer.Propose(0, scene, rng), T, 15.0));
  for (int trial = 0; trial < 50; ++trial) {
    for (SurfacePoint& point : scene) {
      const auto size = static_cast<float>(std::pow(10.0, rng.Uniform(-38.0, 38.0)));
      point = {size * rng.UnitVector().cast<float>(), rng.UnitVector().cast<float>()};
    }
    for (const PoseHypothesis& hypothesis : proposer.Propose(0, scene, rng)) {
      EXPECT_TRUE(hypothesis.T_camera_object.matrix().allFinite());
    }
  }
}

TEST(PpfProposer, FindsTheObjectInAClusterLargerThanIt) {
  const Known known = Asymmetric();
  PpfProposer proposer = Proposer({known});
  Rng rng(13);
  int found = 0;
  for (uint64_t trial = 0; trial < 10; ++trial) {
    const Pose T = RandomPose(rng);
    std::vector<SurfacePoint> scene = Seen(known, T, trial);
    const Eigen::Vector3f beside =
        (T * known.center).cast<float>() + Eigen::Vector3f(0.12F, 0.0F, 0.0F);
    for (int i = 0; i < 150; ++i) {  // A ball.
      Eigen::Vector3f normal = rng.UnitVector().cast<float>();
      if (normal.dot(beside) > 0.0F) normal = -normal;
      scene.push_back({beside + 0.05F * normal, normal});
    }
    if (Holds(known, proposer.Propose(0, scene, rng), T, 15.0)) ++found;
  }
  EXPECT_GE(found, 9);
}

}  // namespace
}  // namespace vantage
