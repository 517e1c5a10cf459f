// Messages that decode but whose numbers are as bad as can be: a conversion refuses them, or what
// it gives is in the range that its readers rely on. Run it under UBSan too.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "common/rng.h"
#include "tests/bus/support/hostile_values.h"

namespace vantage {
namespace {

Pose SomePose() {
  Rng rng(5);
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() = rng.UnitVector();
  return pose;
}

void ExpectSound(const Pose& pose) {
  EXPECT_LE(pose.translation().cwiseAbs().maxCoeff(), 1e6);
  EXPECT_NEAR(
      (pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-9);
}

// How many variants were refused; the rest is checked.
template <class Message, class Check>
int CountRefused(const Message& sound, Check check) {
  EXPECT_TRUE(check(sound));
  const std::vector<Message> variants = HostileVariants(sound);
  int refused = 0;
  for (const Message& variant : variants) refused += check(variant) ? 0 : 1;
  EXPECT_LT(static_cast<size_t>(refused), variants.size());
  return refused;
}

TEST(ConversionFuzz, Poses) {
  const int refused =
      CountRefused(PoseToMessage(SomePose(), 1), [](const rigid_transform_t& message) {
        const Result<Pose> pose = PoseFromMessage(message);
        if (!pose) return false;
        EXPECT_TRUE(IsPlausibleUtime(message.utime));
        ExpectSound(*pose);
        return true;
      });
  EXPECT_GT(refused, 40);
}

TEST(ConversionFuzz, Cameras) {
  const int refused = CountRefused(CameraToMessage({}, {}, 1, 2), [](const camera_info_t& message) {
    const Result<CameraModel> camera = CameraFromMessage(message);
    if (!camera) return false;
    EXPECT_TRUE(IsPlausibleUtime(message.utime));
    // The corners' rays, squared, stay numbers.
    for (const double u : {-0.5, camera->width - 0.5}) {
      const double x = (u - camera->cx) / camera->fx;
      EXPECT_LT(x * x, 1e30) << camera->fx << " " << camera->cx;
    }
    return true;
  });
  EXPECT_GT(refused, 40);
}

TEST(ConversionFuzz, Images) {
  const std::vector<uint16_t> depth(12, 700);
  for (const DepthCompression compression :
       {DepthCompression::kNone, DepthCompression::kZlib, DepthCompression::kVdc}) {
    const images_t sound = DepthToMessage(4, 3, depth, 1, 2, "S", compression);
    const int refused = CountRefused(sound, [](const images_t& message) {
      const Result<DepthFrame> frame = DepthFrameFromMessage(message);
      if (!frame) return false;
      EXPECT_TRUE(IsPlausibleUtime(frame->utime));
      EXPECT_EQ(frame->image.depth.size(), 12U);
      return true;
    });
    EXPECT_GT(refused, 30);
  }
}

TEST(ConversionFuzz, Detections) {
  DetectionSet set{.utime = 1,
                   .seq = 2,
                   .channel = {},
                   .camera = "A",
                   .image_seq = 3,
                   .estimator = "ppf",
                   .T_world_camera = SomePose(),
                   .compute_time = 0.1,
                   .num_clusters = 1,
                   .detections = {}};
  set.detections.push_back({.model_id = "mug",
                            .cluster = 0,
                            .T_camera_object = SomePose(),
                            .mse = 1e-6,
                            .inlier_fraction = 0.5,
                            .verification_score = 0.5});
  const int refused = CountRefused(DetectionsToMessage(set), [](const detections_v2_t& message) {
    const Result<DetectionSet> back = DetectionsFromMessage(message, "D");
    if (!back) return false;
    EXPECT_TRUE(IsPlausibleUtime(back->utime));
    ExpectSound(back->T_world_camera);
    for (const Detection& detection : back->detections) {
      ExpectSound(detection.T_camera_object);
      EXPECT_TRUE(detection.mse >= 0.0 && std::isfinite(detection.mse));
      EXPECT_TRUE(detection.inlier_fraction >= 0.0 && detection.inlier_fraction <= 1.0);
      EXPECT_TRUE(detection.verification_score >= 0.0 && detection.verification_score <= 1.0);
    }
    return true;
  });
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace vantage
