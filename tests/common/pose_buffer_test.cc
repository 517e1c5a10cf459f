#include "common/pose_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000;
constexpr int64_t kMs = 1000;

Pose MakePose(double x, double angle) {
  Pose pose = Pose::Identity();
  pose.translation().x() = x;
  pose.linear() = ExpSo3({0.0, 0.0, angle}).toRotationMatrix();
  return pose;
}

double AngleOf(const Pose& pose) { return LogSo3(Eigen::Quaterniond(pose.linear())).z(); }

// Moves 1 m/s and turns 1 rad/s, 100 Hz over [0, count * 10 ms].
PoseBuffer Moving(int count) {
  PoseBuffer buffer;
  for (int i = 0; i <= count; ++i) {
    buffer.Add(kStart + 10 * kMs * i, MakePose(0.01 * i, 0.01 * i));
  }
  return buffer;
}

TEST(PoseBuffer, InterpolatesLinearly) {
  const PoseBuffer buffer = Moving(100);
  for (const int64_t at : {0, 1, 5, 10, 437, 999, 1000}) {
    const std::optional<Pose> pose = buffer.At(kStart + at * kMs);
    ASSERT_TRUE(pose.has_value()) << at;
    const double expected = 1e-3 * static_cast<double>(at);
    EXPECT_NEAR(pose->translation().x(), expected, 1e-12);
    EXPECT_NEAR(AngleOf(*pose), expected, 1e-12);
  }
}

TEST(PoseBuffer, KnowsNothingOutsideOrAcrossGaps) {
  PoseBuffer buffer;
  EXPECT_FALSE(buffer.At(kStart).has_value());
  EXPECT_FALSE(buffer.Newest().has_value());
  buffer.Add(kStart, MakePose(0.0, 0.0));
  buffer.Add(kStart + 200 * kMs, MakePose(1.0, 0.0));
  buffer.Add(kStart + 401 * kMs, MakePose(2.0, 0.0));
  EXPECT_FALSE(buffer.At(kStart - 1).has_value());
  EXPECT_FALSE(buffer.At(kStart + 401 * kMs + 1).has_value());
  EXPECT_TRUE(buffer.At(kStart + 100 * kMs).has_value());
  EXPECT_FALSE(buffer.At(kStart + 300 * kMs).has_value());  // 201 ms of silence
  EXPECT_TRUE(buffer.At(kStart + 200 * kMs).has_value());
  EXPECT_EQ(buffer.Newest(), kStart + 401 * kMs);
}

TEST(PoseBuffer, OrderWithinTheGapDoesNotMatter) {
  const PoseBuffer ordered = Moving(100);
  // Each of 0 to 190 ms of delay.
  std::vector<std::pair<int, int>> order;  // arrival, measurement
  Rng rng(1);
  for (int i = 0; i <= 100; ++i) order.emplace_back(i + static_cast<int>(rng.Below(20)), i);
  std::sort(order.begin(), order.end());
  PoseBuffer shuffled;
  for (const auto& [arrival, i] : order) {
    EXPECT_FALSE(shuffled.Add(kStart + 10 * kMs * i, MakePose(0.01 * i, 0.01 * i)));
  }
  for (int64_t at = 0; at <= 1000; at += 7) {
    const std::optional<Pose> a = ordered.At(kStart + at * kMs);
    const std::optional<Pose> b = shuffled.At(kStart + at * kMs);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->matrix(), b->matrix());
  }
}

TEST(PoseBuffer, ASecondPoseOfATimeReplacesTheFirst) {
  PoseBuffer buffer;
  buffer.Add(kStart, MakePose(1.0, 0.0));
  buffer.Add(kStart, MakePose(2.0, 0.0));
  EXPECT_EQ(buffer.At(kStart)->translation().x(), 2.0);
}

TEST(PoseBuffer, ForgetsBeyondItsHorizon) {
  PoseBuffer::Parameters parameters;
  parameters.horizon_us = 500 * kMs;
  PoseBuffer buffer(parameters);
  for (int i = 0; i <= 100; ++i) buffer.Add(kStart + 10 * kMs * i, MakePose(0.0, 0.0));
  EXPECT_FALSE(buffer.At(kStart + 499 * kMs).has_value());
  EXPECT_TRUE(buffer.At(kStart + 500 * kMs).has_value());
}

TEST(PoseBuffer, StartsAnewWhenTheClockIsSetBack) {
  for (const int64_t step : {int64_t{3'600'000}, int64_t{2'000}, int64_t{201}}) {
    PoseBuffer buffer = Moving(10);
    const int64_t set_back = kStart + (100 - step) * kMs;
    EXPECT_TRUE(buffer.Add(set_back, MakePose(5.0, 0.0))) << step;
    EXPECT_EQ(buffer.Newest(), set_back);
    EXPECT_FALSE(buffer.At(kStart + 50 * kMs).has_value());
    EXPECT_FALSE(buffer.Add(set_back + 10 * kMs, MakePose(5.0, 0.0)));
  }
}

// Two passes over the same times, as a log played again or a clock set back by 2 s gives.
TEST(PoseBuffer, PosesOfTwoPassesAreNeverMixed) {
  PoseBuffer buffer;
  for (int64_t at = 0; at <= 3000; at += 10) buffer.Add(kStart + at * kMs, MakePose(1.0, 0.0));
  for (int64_t at = 1000; at <= 2000; at += 10) {
    buffer.Add(kStart + at * kMs, MakePose(2.0, 0.0));
    EXPECT_EQ(buffer.Newest(), kStart + at * kMs);
    for (int64_t asked = 0; asked <= 3000; asked += 45) {
      const std::optional<Pose> pose = buffer.At(kStart + asked * kMs);
      EXPECT_EQ(pose.has_value(), asked >= 1000 && asked <= at) << asked << " at " << at;
      if (pose) {
        EXPECT_EQ(pose->translation().x(), 2.0);
      }
    }
  }
  EXPECT_TRUE(buffer.RestsAt(kStart + 1500 * kMs, 150 * kMs));
  EXPECT_FALSE(buffer.RestsAt(kStart + 1100 * kMs, 150 * kMs));
}

TEST(PoseBuffer, TimesAtTheEndsOfTheirTypeAreLeftOut) {
  constexpr int64_t kMin = std::numeric_limits<int64_t>::min();
  constexpr int64_t kMax = std::numeric_limits<int64_t>::max();
  PoseBuffer buffer;
  for (const int64_t utime : {kMin, kMax, int64_t{-1}}) {
    buffer.Add(utime, MakePose(1.0, 0.0));
    EXPECT_FALSE(buffer.Newest().has_value()) << utime;
  }
  buffer = Moving(10);
  for (const int64_t utime : {kMin, kMax}) {
    buffer.Add(utime, MakePose(1.0, 0.0));
    EXPECT_FALSE(buffer.At(utime).has_value());
    EXPECT_FALSE(buffer.RestsAt(utime, 100 * kMs));
  }
  EXPECT_EQ(buffer.Newest(), kStart + 100 * kMs);
  EXPECT_TRUE(buffer.At(kStart + 50 * kMs).has_value());
}

TEST(PoseBuffer, RestsOnlyWithinItsLimits) {
  PoseBuffer still;
  PoseBuffer shifted;
  PoseBuffer turned;
  for (int i = 0; i <= 100; ++i) {
    const int64_t utime = kStart + 10 * kMs * i;
    const bool late = i > 60;
    still.Add(utime, MakePose(late ? 0.0004 : 0.0, late ? 0.09 * kDegree : 0.0));
    shifted.Add(utime, MakePose(late ? 0.0006 : 0.0, 0.0));
    turned.Add(utime, MakePose(0.0, late ? 0.11 * kDegree : 0.0));
  }
  const int64_t middle = kStart + 500 * kMs;
  EXPECT_TRUE(still.RestsAt(middle, 200 * kMs));
  EXPECT_FALSE(shifted.RestsAt(middle, 200 * kMs));
  EXPECT_FALSE(turned.RestsAt(middle, 200 * kMs));
  EXPECT_TRUE(shifted.RestsAt(middle, 90 * kMs));  // Before it moves.
  EXPECT_FALSE(Moving(100).RestsAt(middle, 100 * kMs));
}

TEST(PoseBuffer, RestNeedsPosesAllAround) {
  PoseBuffer buffer;
  for (int i = 0; i <= 50; ++i) buffer.Add(kStart + 10 * kMs * i, MakePose(0.0, 0.0));
  EXPECT_TRUE(buffer.RestsAt(kStart + 250 * kMs, 250 * kMs));
  EXPECT_FALSE(buffer.RestsAt(kStart + 251 * kMs, 250 * kMs));
  EXPECT_FALSE(buffer.RestsAt(kStart + 249 * kMs, 250 * kMs));
  PoseBuffer gap;
  for (int i = 0; i <= 100; ++i) {
    if (i > 55 && i < 80) continue;  // 250 ms of silence
    gap.Add(kStart + 10 * kMs * i, MakePose(0.0, 0.0));
  }
  EXPECT_TRUE(gap.RestsAt(kStart + 300 * kMs, 200 * kMs));
  EXPECT_FALSE(gap.RestsAt(kStart + 500 * kMs, 400 * kMs));
}

}  // namespace
}  // namespace vantage
