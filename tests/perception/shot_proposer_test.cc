#include "perception/shot/shot_proposer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "common/rng.h"
#include "common/symmetry_group.h"
#include "perception/model/model_builder.h"
#include "perception/segmentation/normals.h"
#include "perception/shot/inner_products.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const ObjectModel& Asymmetric() {
  static const ObjectModel model =
      BuildObjectModel("asymmetric", MakeAsymmetric(), SymmetryGroup::None(), "test", {}).value();
  return model;
}

ShotParameters QuickParameters() {
  ShotParameters parameters;
  parameters.training_views = 30;
  return parameters;
}

ShotProposer& Proposer() {
  static const std::unique_ptr<ShotProposer> proposer =
      ShotProposer::Create(std::span(&Asymmetric(), 1), QuickParameters()).value();
  return *proposer;
}

// What a camera without noise sees of the model, as points.
std::vector<SurfacePoint> Seen(const Pose& T_camera_object) {
  const CameraModel camera;
  DepthRasterizer rasterizer(camera);
  rasterizer.Clear();
  rasterizer.Draw(Asymmetric().mesh, T_camera_object);
  const DepthImage image = ToImage(rasterizer);
  std::vector<int32_t> labels(image.depth.size(), -1);
  std::vector<uint32_t> pixels;
  for (uint32_t i = 0; i < image.depth.size(); ++i) {
    if (!(image.depth[i] > 0.0F)) continue;
    labels[i] = 0;
    pixels.push_back(i);
  }
  return SampleSurfaces(image, camera, labels, pixels, Proposer().Spacing(0), {});
}

Pose PoseAt(const Eigen::Quaterniond& rotation, double distance) {
  Pose T(rotation);
  T.translation() = Eigen::Vector3d(0.02, -0.03, distance) - T.linear() * Asymmetric().center;
  return T;
}

bool IsNear(const Pose& a, const Pose& b) {
  return GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) <
             15.0 * kDegree &&
         (a * Asymmetric().center - b * Asymmetric().center).norm() < 0.1 * Asymmetric().diameter;
}

TEST(ShotProposer, FindsPosesOfWhatItSees) {
  Rng rng(3);
  int found = 0;
  constexpr int kViews = 20;
  for (int view = 0; view < kViews; ++view) {
    const Pose T = PoseAt(rng.Rotation(), rng.Uniform(0.5, 0.8));
    const auto hypotheses = Proposer().Propose(0, Seen(T), rng);
    found += std::any_of(hypotheses.begin(),
                         hypotheses.end(),
                         [&T](const PoseHypothesis& h) { return IsNear(h.T_camera_object, T); })
                 ? 1
                 : 0;
  }
  EXPECT_GE(found, kViews - 1);
}

TEST(ShotProposer, GivesDistinctHypothesesMostVotesFirst) {
  Rng rng(5);
  const auto hypotheses = Proposer().Propose(0, Seen(PoseAt(rng.Rotation(), 0.6)), rng);
  ASSERT_GE(hypotheses.size(), 2U);
  EXPECT_LE(hypotheses.size(), static_cast<size_t>(QuickParameters().max_hypotheses));
  for (size_t i = 0; i < hypotheses.size(); ++i) {
    EXPECT_NEAR(hypotheses[i].T_camera_object.linear().determinant(), 1.0, 1e-9);
    for (size_t j = 0; j < i; ++j) {
      EXPECT_GE(hypotheses[j].votes, hypotheses[i].votes);
      EXPECT_FALSE(hypotheses[i].T_camera_object.isApprox(hypotheses[j].T_camera_object, 1e-3));
    }
  }
}

TEST(ShotProposer, IsTheSameForTheSameState) {
  Rng rng(7);
  const std::vector<SurfacePoint> scene = Seen(PoseAt(rng.Rotation(), 0.6));
  Rng one(9);
  const auto first = Proposer().Propose(0, scene, one);
  const std::vector<PoseHypothesis> kept(first.begin(), first.end());
  Proposer().Propose(0, Seen(PoseAt(rng.Rotation(), 0.7)), rng);  // Leaves nothing behind.
  Rng two(9);
  const auto second = Proposer().Propose(0, scene, two);
  ASSERT_EQ(kept.size(), second.size());
  for (size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].votes, second[i].votes);
    EXPECT_EQ(kept[i].T_camera_object.matrix(), second[i].T_camera_object.matrix());
  }
}

TEST(ShotProposer, GivesNothingForTooLittle) {
  Rng rng(11);
  const SurfacePoint point{{0.0F, 0.0F, 0.7F}, {0.0F, 0.0F, -1.0F}};
  EXPECT_TRUE(Proposer().Propose(0, {}, rng).empty());
  EXPECT_TRUE(Proposer().Propose(0, std::vector<SurfacePoint>(2, point), rng).empty());
  EXPECT_TRUE(Proposer().Propose(0, std::vector<SurfacePoint>(500, point), rng).empty());
}

TEST(ShotProposer, IsNotHarmedByPointsThatAreNone) {
  Rng rng(13);
  std::vector<SurfacePoint> scene = Seen(PoseAt(rng.Rotation(), 0.6));
  Rng one(1);
  const auto clean = Proposer().Propose(0, scene, one);
  const std::vector<PoseHypothesis> kept(clean.begin(), clean.end());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  scene.push_back({{nan, 0.0F, 0.6F}, {0.0F, 0.0F, -1.0F}});
  scene.push_back({{0.0F, infinity, 0.6F}, {0.0F, 0.0F, -1.0F}});
  scene.push_back({{0.0F, 0.0F, 1e30F}, {0.0F, 0.0F, -1.0F}});
  scene.push_back({{0.0F, 0.0F, 0.6F}, {nan, 0.0F, -1.0F}});
  scene.push_back({{0.0F, 0.0F, 0.6F}, {0.0F, 0.0F, 0.0F}});
  Rng two(1);
  const auto dirty = Proposer().Propose(0, scene, two);
  ASSERT_EQ(kept.size(), dirty.size());
  for (size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].T_camera_object.matrix(), dirty[i].T_camera_object.matrix());
  }
}

TEST(ShotProposer, GivesFinitePosesForAPlane) {
  std::vector<SurfacePoint> scene;
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) {
      scene.push_back({{0.004F * static_cast<float>(i), 0.004F * static_cast<float>(j), 0.7F},
                       {0.0F, 0.0F, -1.0F}});
    }
  }
  Rng rng(17);
  for (const PoseHypothesis& hypothesis : Proposer().Propose(0, scene, rng)) {
    EXPECT_TRUE(hypothesis.T_camera_object.matrix().allFinite());
  }
}

TEST(ShotProposer, RefusesParametersOutOfRange) {
  const auto refuses = [](auto change) {
    ShotParameters parameters;
    change(parameters);
    return !parameters.Validate().ok() &&
           !ShotProposer::Create(std::span(&Asymmetric(), 1), parameters).ok();
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(ShotParameters{}.Validate().ok());
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.spacing = 0.0; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.keypoint_spacing = 0.01; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.descriptor_radius = kNan; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.descriptor_size = 353; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.k = 0; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.t_r = -0.1; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.t_d = kNan; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.t_alpha_deg = 181.0; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.probability = 1.0; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.max_iterations = 0; }));
  EXPECT_TRUE(refuses([](ShotParameters& p) { p.max_hypotheses = 0; }));
}

TEST(InnerProducts, AreTheSumsOfProducts) {
  Rng rng(19);
  for (const size_t dimension : {1U, 7U, 64U}) {
    for (const size_t count : {1U, 15U, 16U, 33U}) {
      std::vector<float> vectors(count * dimension);
      std::vector<float> queries(5 * dimension);
      for (float& value : vectors) value = static_cast<float>(rng.Normal());
      for (float& value : queries) value = static_cast<float>(rng.Normal());
      const InnerProducts products(vectors, dimension);
      std::vector<float> found;
      products.Compute(queries, &found);
      ASSERT_EQ(found.size(), 5 * products.stride());
      for (size_t i = 0; i < 5; ++i) {
        for (size_t j = 0; j < count; ++j) {
          double sum = 0.0;
          for (size_t d = 0; d < dimension; ++d) {
            sum += static_cast<double>(queries[i * dimension + d]) *
                   static_cast<double>(vectors[j * dimension + d]);
          }
          EXPECT_NEAR(found[i * products.stride() + j], sum, 1e-4);
        }
      }
    }
  }
}

}  // namespace
}  // namespace vantage
