#include "nodes/depth_memory.h"

#include <gtest/gtest.h>

#include <vector>

#include "bus/image_conversion.h"

namespace vantage {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000;

CameraModel Camera() {
  CameraModel camera;
  camera.width = 4;
  camera.height = 3;
  return camera;
}

images_t Image(int64_t utime, uint16_t millimetres) {
  const std::vector<uint16_t> depth(12, millimetres);
  return DepthToMessage(4, 3, depth, utime, 0, "", DepthCompression::kZlib);
}

Pose At(double x) {
  Pose pose = Pose::Identity();
  pose.translation().x() = x;
  return pose;
}

TEST(DepthMemory, KeepsTheImageOfATimeWithItsPose) {
  DepthMemory memory(5);
  for (int i = 0; i < 3; ++i) {
    memory.Add(Image(kStart + i, static_cast<uint16_t>(500 + i)));
  }
  ASSERT_TRUE(memory.Keep(kStart + 1, At(0.25), Camera()));
  ASSERT_EQ(memory.views().size(), 1U);
  const auto& [utime, view] = *memory.views().begin();
  EXPECT_EQ(utime, kStart + 1);
  EXPECT_FLOAT_EQ(view.depth.at(3, 2), 0.501F);
  EXPECT_EQ(view.T_world_camera.translation().x(), 0.25);
}

TEST(DepthMemory, WhatNeverCameIsNotKept) {
  DepthMemory memory(5);
  memory.Add(Image(kStart, 500));
  EXPECT_TRUE(memory.Keep(kStart + 7, At(0.0), Camera()));
  EXPECT_TRUE(memory.views().empty());
}

TEST(DepthMemory, IsBounded) {
  DepthMemory memory(2);
  const auto most = static_cast<int64_t>(DepthMemory::kMostWaiting);
  for (int64_t i = 0; i <= most; ++i) memory.Add(Image(kStart + i, 500));
  ASSERT_TRUE(memory.Keep(kStart, At(0.0), Camera()));
  EXPECT_TRUE(memory.views().empty()) << "the oldest had to go";
  for (int64_t i = 1; i < 5; ++i) ASSERT_TRUE(memory.Keep(kStart + i, At(0.0), Camera()));
  EXPECT_EQ(memory.views().size(), 2U);
}

TEST(DepthMemory, ForgetsWhatIsNotUsed) {
  DepthMemory memory(5);
  for (int64_t i = 0; i < 3; ++i) {
    memory.Add(Image(kStart + i, 500));
    ASSERT_TRUE(memory.Keep(kStart + i, At(0.0), Camera()));
  }
  memory.KeepOnly({kStart + 1, kStart + 9});
  ASSERT_EQ(memory.views().size(), 1U);
  EXPECT_EQ(memory.views().begin()->first, kStart + 1);
}

TEST(DepthMemory, RefusesADamagedImageAndOneOfAnotherSize) {
  DepthMemory memory(5);
  images_t damaged = Image(kStart, 500);
  damaged.images[0].data.resize(damaged.images[0].data.size() / 2);
  damaged.images[0].size = static_cast<int32_t>(damaged.images[0].data.size());
  memory.Add(damaged);
  EXPECT_FALSE(memory.Keep(kStart, At(0.0), Camera()));
  memory.Add(Image(kStart + 1, 500));
  CameraModel other = Camera();
  other.width = 8;
  const Result<void> kept = memory.Keep(kStart + 1, At(0.0), other);
  ASSERT_FALSE(kept);
  EXPECT_NE(kept.error().message.find("4 x 3 px, expected the camera's 8 x 3 px"),
            std::string::npos)
      << kept.error().message;
  EXPECT_TRUE(memory.views().empty());
}

}  // namespace
}  // namespace vantage
