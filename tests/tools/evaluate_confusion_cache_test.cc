#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "tools/evaluate/confusion_view_cache.h"
#include "tools/evaluate/confusion_views.h"

namespace vantage {
namespace {

class ConfusionViewCacheTest : public ScratchTest {
 protected:
  [[nodiscard]] std::unique_ptr<ConfusionViewCache> Open(const std::string& key = "key 1\n") const {
    auto cache = ConfusionViewCache::Open(scratch() / "views", "mug", key);
    EXPECT_TRUE(cache.ok());
    return cache ? std::move(cache).value() : nullptr;
  }
  static SeenFrom From(int sequence, int step) {
    SeenFrom from{sequence, step, Pose::Identity()};
    from.T_world_camera.translation() = Eigen::Vector3d(0.1, 0.2, 1.0 / 3.0);
    return from;
  }
  static SeenOrientation Seen() {
    return {Eigen::Quaterniond(Eigen::AngleAxisd(1.0 / 7.0, Eigen::Vector3d::UnitX())), 1e-7};
  }
};

TEST_F(ConfusionViewCacheTest, GivesBackWhatItKeptToTheLastBit) {
  ASSERT_TRUE(Open()->Keep(From(0, 1), Seen()).ok());
  ASSERT_TRUE(Open()->Keep(From(0, 2), {}).ok());
  const auto cache = Open();
  EXPECT_TRUE(cache->note().empty());
  const auto found = cache->Find(From(0, 1));
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->q_world_object->coeffs(), Seen().q_world_object->coeffs());
  EXPECT_EQ(found->mse, 1e-7);
  ASSERT_TRUE(cache->Find(From(0, 2)).has_value());
  EXPECT_FALSE(cache->Find(From(0, 2))->q_world_object.has_value());
  EXPECT_FALSE(cache->Find(From(1, 1)).has_value());
  SeenFrom elsewhere = From(0, 1);
  elsewhere.T_world_camera.translation().x() += 1e-12;
  EXPECT_FALSE(cache->Find(elsewhere).has_value());
  EXPECT_FALSE(Open("key 2\n")->Find(From(0, 1)).has_value());
}

TEST_F(ConfusionViewCacheTest, WhatIsDamagedIsMadeAgain) {
  std::filesystem::path file;
  {
    const auto cache = Open();
    for (int step = 0; step < 3; ++step) ASSERT_TRUE(cache->Keep(From(0, step), Seen()).ok());
    file = cache->file();
  }
  std::string text = ReadFileBytes(file, 1U << 20U).value();
  const std::string whole = text;
  // Any byte of the last line, and a line cut at any place.
  for (size_t at = whole.rfind('\n', whole.size() - 2) + 1; at + 1 < whole.size(); at += 5) {
    for (const bool is_cut : {false, true}) {
      text = whole;
      text[at] = text[at] == 'x' ? 'y' : 'x';
      if (is_cut) text.resize(at);
      ASSERT_TRUE(WriteFileBytes(file, text).ok());
      const auto cache = Open();
      EXPECT_TRUE(cache->Find(From(0, 0)).has_value());
      EXPECT_FALSE(cache->Find(From(0, 2)).has_value());
      ASSERT_TRUE(cache->Keep(From(0, 2), Seen()).ok());
      EXPECT_TRUE(Open()->Find(From(0, 2)).has_value());
      EXPECT_TRUE(Open()->note().empty());
    }
  }
}

TEST_F(ConfusionViewCacheTest, RefusesAFileOfAnotherKey) {
  std::filesystem::path file = Open()->file();
  ASSERT_TRUE(WriteFileBytes(file, "something else\n").ok());
  const auto cache = ConfusionViewCache::Open(scratch() / "views", "mug", "key 1\n");
  ASSERT_FALSE(cache.ok());
  EXPECT_NE(cache.error().message.find(file.string()), std::string::npos);
}

TEST(BandOfViews, IsEvenAndLooksAtTheTarget) {
  ConfusionViewsParameters parameters;
  const Eigen::Vector3d target(0.1, -0.2, 0.05);
  const std::vector<Pose> poses = BandOfViews(target, 0.8, parameters);
  ASSERT_EQ(poses.size(), 500U);
  double mean_z = 0.0;
  for (const Pose& pose : poses) {
    const Eigen::Vector3d to_camera = pose.translation() - target;
    EXPECT_NEAR(to_camera.norm(), 0.8, 1e-12);
    EXPECT_LT((pose.linear().col(2) + to_camera / 0.8).norm(), 1e-9);
    const double elevation = std::asin(to_camera.z() / 0.8) / kDegree;
    EXPECT_GE(elevation, 15.0);
    EXPECT_LE(elevation, 80.0);
    mean_z += to_camera.z() / 0.8 / 500.0;
    double nearest = std::numbers::pi;
    for (const Pose& other : poses) {
      if (&other == &pose) continue;
      nearest = std::min(nearest, (other.translation() - pose.translation()).norm() / 0.8);
    }
    EXPECT_GT(nearest, 3.5 * kDegree);
    EXPECT_LT(nearest, 8.5 * kDegree);
  }
  const double middle = 0.5 * (std::sin(15.0 * kDegree) + std::sin(80.0 * kDegree));
  EXPECT_NEAR(mean_z, middle, 1e-3);
}

TEST(ConfusionViewsParameters, RefusesWhatIsOutOfRange) {
  ConfusionViewsParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.views = 501;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters.views = 0;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.distance = std::nan("");
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
