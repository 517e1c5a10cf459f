#include "tools/support/message_comparison.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "bus/message_check.h"
#include "common/so3.h"
#include "vantage/detections_v2_t.hpp"
#include "vantage/image_metadata_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

object_estimates_v3_t Sound() {
  object_estimates_v3_t message{};
  message.utime = 1'000'000;
  message.seq = 7;
  message.num_objects = 2;
  message.objects.resize(2);
  for (object_estimate_v3_t& object : message.objects) {
    object.model_id = "mug";
    object.trans[0] = 0.25;
    object.entropy = 2.0;
    object.refined_quat[0] = 1.0;
    object.num_peaks = 1;
    object.peaks.resize(1);
    object.peaks[0].quat[0] = 0.6;
    object.peaks[0].quat[1] = 0.8;
  }
  return message;
}

using Change = std::function<void(object_estimates_v3_t&)>;

MessageComparison Compare(const Change& change_first,
                          const Change& change_second,
                          const ComparisonTolerance& tolerance = {}) {
  object_estimates_v3_t first = Sound();
  object_estimates_v3_t second = Sound();
  change_first(first);
  change_second(second);
  return CompareMessages(Encode(first), Encode(second), tolerance);
}

MessageComparison Compare(const Change& change, const ComparisonTolerance& tolerance = {}) {
  return Compare([](object_estimates_v3_t&) {}, change, tolerance);
}

Change Turned(double angle) {
  return [angle](object_estimates_v3_t& message) {
    auto& quat = message.objects[1].peaks[0].quat;
    const Eigen::Quaterniond q = Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]) *
                                 ExpSo3(Eigen::Vector3d(0.0, angle, 0.0));
    quat[0] = q.w();
    quat[1] = q.x();
    quat[2] = q.y();
    quat[3] = q.z();
  };
}

TEST(MessageComparison, EqualMessagesAreEqual) {
  const MessageComparison compared = Compare([](object_estimates_v3_t&) {});
  EXPECT_TRUE(compared.identical);
  EXPECT_TRUE(compared.within);
  EXPECT_FALSE(compared.beyond.has_value());
}

// However wide the tolerances of other kinds are.
TEST(MessageComparison, FailsOnEveryKindOfDifference) {
  constexpr double kWide = 1e9;
  const ComparisonTolerance not_angle{kWide, 0.0, kWide, kWide};
  const ComparisonTolerance not_position{0.0, kWide, kWide, kWide};
  const ComparisonTolerance not_number{kWide, kWide, 0.0, 0.0};
  const ComparisonTolerance all{kWide, kWide, kWide, kWide};
  struct Case {
    const char* path;
    Change change;
    ComparisonTolerance tolerance;
  };
  for (const auto& [path, change, tolerance] : std::initializer_list<Case>{
           {"objects[1].peaks[0].quat", Turned(1e-6), not_angle},
           {"objects[1].trans", [](auto& m) { m.objects[1].trans[0] += 1e-9; }, not_position},
           {"objects[0].entropy", [](auto& m) { m.objects[0].entropy += 1e-9; }, not_number},
           {"objects[0].trans_covariance[8]",
            [](auto& m) { m.objects[0].trans_covariance[8] = 1e-30; },
            not_number},
           {"objects[0].entropy", [](auto& m) { m.objects[0].entropy = kNan; }, all},
           {"objects[0].trans[0]", [](auto& m) { m.objects[0].trans[0] = kNan; }, all},
           {"objects[0].refined_quat[0]",
            [](auto& m) { m.objects[0].refined_quat[0] = kNan; },
            all},
           {"objects[0].entropy", [](auto& m) { m.objects[0].entropy = kInfinity; }, all},
           {"seq", [](auto& m) { m.seq = 8; }, all},
           {"finished", [](auto& m) { m.finished = 1; }, all},
           {"objects[0].state", [](auto& m) { m.objects[0].state = 1; }, all},
           {"objects[1].model_id", [](auto& m) { m.objects[1].model_id = "cup"; }, all},
           {"num_objects",
            [](auto& m) {
              m.objects.pop_back();
              m.num_objects = 1;
            },
            all}}) {
    const MessageComparison compared = Compare(change, tolerance);
    EXPECT_FALSE(compared.within) << path;
    EXPECT_FALSE(compared.identical) << path;
    ASSERT_TRUE(compared.beyond.has_value()) << path;
    EXPECT_EQ(compared.beyond->path, path);
    EXPECT_NE(compared.beyond->first, compared.beyond->second) << path;
  }
}

TEST(MessageComparison, MeasuresAndTolerates) {
  const MessageComparison turned = Compare(Turned(0.5 * kDegree), {0.0, 0.6, 0.0, 0.0});
  EXPECT_TRUE(turned.within);
  EXPECT_FALSE(turned.identical);
  EXPECT_NEAR(turned.angle_deg, 0.5, 1e-9);
  EXPECT_FALSE(Compare(Turned(0.5 * kDegree), {0.0, 0.4, 0.0, 0.0}).within);

  const Change moved = [](auto& m) {
    m.objects[0].trans[0] += 0.003;
    m.objects[0].trans[2] += 0.004;
  };
  const MessageComparison position = Compare(moved, {5.001, 0.0, 0.0, 0.0});
  EXPECT_TRUE(position.within);
  EXPECT_NEAR(position.position_mm, 5.0, 1e-9);
  EXPECT_FALSE(Compare(moved, {4.999, 0.0, 0.0, 0.0}).within);

  const Change more = [](auto& m) { m.objects[0].entropy = 2.2; };
  EXPECT_NEAR(Compare(more).number, 0.2, 1e-12);
  EXPECT_TRUE(Compare(more, {0.0, 0.0, 0.21, 0.0}).within);
  EXPECT_TRUE(Compare(more, {0.0, 0.0, 0.0, 0.11}).within);
  EXPECT_TRUE(Compare(more, {0.0, 0.0, 0.11, 0.05}).within);
  EXPECT_FALSE(Compare(more, {0.0, 0.0, 0.09, 0.05}).within);
}

TEST(MessageComparison, OppositeQuaternionsAreOneOrientation) {
  const MessageComparison compared = Compare([](auto& m) {
    for (double& each : m.objects[0].peaks[0].quat) each = -each;
  });
  EXPECT_TRUE(compared.within);
  EXPECT_FALSE(compared.identical) << "but not the same bits";
  EXPECT_EQ(compared.angle_deg, 0.0);
}

TEST(MessageComparison, NanEqualsNanAlone) {
  const auto with = [](double value) -> Change {
    return [value](auto& m) { m.objects[0].entropy = value; };
  };
  EXPECT_TRUE(Compare(with(kNan), with(-kNan)).within);
  EXPECT_TRUE(Compare(with(kInfinity), with(kInfinity)).within);
  EXPECT_FALSE(Compare(with(kInfinity), with(-kInfinity), {1.0, 1.0, 1.0, 1.0}).within);
  EXPECT_FALSE(Compare(with(kInfinity), with(1.0), {1.0, 1.0, 1.0, 1.0}).within);
  EXPECT_FALSE(Compare(with(kNan), with(1.0), {1.0, 1.0, 1.0, 1.0}).within);
  EXPECT_TRUE(Compare(with(0.0), with(-0.0)).within);
}

TEST(MessageComparison, WallClockIsNotCompared) {
  detections_v2_t first{};
  detections_v2_t second{};
  second.compute_time = 0.7;
  const MessageComparison compared = CompareMessages(Encode(first), Encode(second), {});
  EXPECT_TRUE(compared.identical && compared.within);
  second.num_clusters = 1;
  EXPECT_FALSE(CompareMessages(Encode(first), Encode(second), {}).within);
}

TEST(MessageComparison, BulkBytesDifferAtAPlace) {
  image_metadata_t first{};
  first.n = 1000;
  first.value.resize(1000);
  image_metadata_t second = first;
  second.value[998] = 3;
  const MessageComparison compared = CompareMessages(Encode(first), Encode(second), {9, 9, 9, 9});
  ASSERT_TRUE(compared.beyond.has_value());
  EXPECT_EQ(compared.beyond->path, "value[998]");
  EXPECT_EQ(compared.beyond->second, "3");
}

TEST(MessageComparison, OtherTypesAndBytesThatAreNoMessage) {
  const std::vector<std::byte> ours = Encode(Sound());
  const std::vector<std::byte> other = Encode(next_view_t{});
  EXPECT_EQ(CompareMessages(ours, other, {}).beyond->path, "the type");
  const std::vector<std::byte> noise(20, std::byte{3});
  EXPECT_TRUE(CompareMessages(noise, noise, {}).within);
  EXPECT_FALSE(CompareMessages(noise, ours, {}).within);
  EXPECT_FALSE(CompareMessages({}, noise, {}).within);
  EXPECT_TRUE(CompareMessages({}, {}, {}).within);
  const std::span<const std::byte> cut = std::span(ours).first(ours.size() - 1);
  const MessageComparison damaged = CompareMessages(ours, cut, {9, 9, 9, 9});
  ASSERT_TRUE(damaged.beyond.has_value());
  EXPECT_EQ(damaged.beyond->path, "the bytes");
}

}  // namespace
}  // namespace vantage
