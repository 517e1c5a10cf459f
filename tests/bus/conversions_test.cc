#include "bus/conversions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "bus/message_check.h"
#include "common/rng.h"

namespace vantage {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr int64_t kMinTime = std::numeric_limits<int64_t>::min();
constexpr int64_t kMaxTime = std::numeric_limits<int64_t>::max();

Pose RandomPose(Rng& rng) {
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() = 3.0 * rng.UnitVector();
  return pose;
}

TEST(PoseConversion, RoundTrips) {
  Rng rng(1);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = RandomPose(rng);
    const rigid_transform_t message = PoseToMessage(pose, 42);
    EXPECT_EQ(message.utime, 42);
    const Result<Pose> back = PoseFromMessage(message);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_TRUE(back.value().isApprox(pose, 1e-12));
  }
}

TEST(PoseConversion, TheWireHasWFirst) {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3({0.0, 0.0, 0.5}).toRotationMatrix();
  const rigid_transform_t message = PoseToMessage(pose, 0);
  EXPECT_NEAR(message.quat[0], std::cos(0.25), 1e-12);
  EXPECT_NEAR(message.quat[3], std::sin(0.25), 1e-12);
}

TEST(PoseConversion, RefusesHostileValues) {
  for (const double bad : {kNan, kInf, 1e300}) {
    for (int i = 0; i < 7; ++i) {
      rigid_transform_t message = PoseToMessage(Pose::Identity(), 0);
      (i < 3 ? message.trans[i] : message.quat[i - 3]) = bad;
      EXPECT_FALSE(PoseFromMessage(message).ok()) << bad << " at " << i;
    }
  }
  rigid_transform_t zero{};
  EXPECT_FALSE(PoseFromMessage(zero).ok());
  for (const int64_t bad : {kMinTime, kMaxTime, int64_t{-1}}) {
    const Result<Pose> pose = PoseFromMessage(PoseToMessage(Pose::Identity(), bad));
    ASSERT_FALSE(pose.ok()) << bad;
    EXPECT_NE(pose.error().message.find(std::to_string(bad)), std::string::npos);
  }
}

TEST(CameraConversion, RoundTrips) {
  const CameraModel camera{
      .width = 320, .height = 200, .fx = 301.5, .fy = 302.5, .cx = 160.25, .cy = 99.75};
  const camera_info_t message = CameraToMessage(
      camera,
      {.name = "XTION", .serial = "S1", .frame = "f", .registered = true, .calibration_id = "c"},
      7,
      8);
  EXPECT_EQ(message.utime, 7);
  EXPECT_EQ(message.seq, 8);
  EXPECT_EQ(message.name, "XTION");
  EXPECT_EQ(message.depth_unit, 0.001);
  const Result<CameraModel> back = CameraFromMessage(message);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(*back, camera);
}

TEST(CameraConversion, TellsTheDistortionThatIsLeft) {
  EXPECT_EQ(CameraToMessage({}, {}, 1, 2).distortion_model, "none");
  const camera_info_t message =
      CameraToMessage({}, {}, 1, 2, {.k1 = 0.1, .k2 = 0.2, .p1 = 0.3, .p2 = 0.4, .k3 = 0.5});
  EXPECT_EQ(message.distortion_model, "brown_conrady");
  EXPECT_EQ(message.num_distortion, 5);
  EXPECT_EQ(message.distortion, (std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5}));
  EXPECT_FALSE(CameraFromMessage(message).ok());  // No pinhole camera.
}

TEST(CameraConversion, RefusesHostileValues) {
  const std::vector<std::function<void(camera_info_t*)>> attacks = {
      [](camera_info_t* m) { m->utime = kMinTime; },
      [](camera_info_t* m) { m->utime = kMaxTime; },
      [](camera_info_t* m) { m->width = 0; },
      [](camera_info_t* m) { m->height = INT32_MAX; },
      [](camera_info_t* m) { m->fx = kNan; },
      [](camera_info_t* m) { m->fy = -1.0; },
      [](camera_info_t* m) { m->cx = kInf; },
      [](camera_info_t* m) { m->depth_unit = 0.0; },
      [](camera_info_t* m) { m->depth_unit = 0.0001; },
      [](camera_info_t* m) { m->depth_unit = 1.0; },
      [](camera_info_t* m) { m->depth_unit = kNan; },
      [](camera_info_t* m) {
        m->distortion_model = "brown_conrady";
        m->num_distortion = 1;
        m->distortion = {0.1};
      }};
  for (size_t i = 0; i < attacks.size(); ++i) {
    camera_info_t message = CameraToMessage({}, {}, 0, 0);
    ASSERT_TRUE(CameraFromMessage(message).ok());
    attacks[i](&message);
    EXPECT_FALSE(CameraFromMessage(message).ok()) << i;
  }
}

Eigen::Matrix<double, 6, 6> RandomCovariance(Rng& rng) {
  Eigen::Matrix<double, 6, 6> root;
  for (double& value : root.reshaped()) value = rng.Normal();
  const Eigen::Matrix<double, 6, 6> product = root * root.transpose();
  return 0.5 * (product + product.transpose());
}

DetectionSet SomeDetections() {
  Rng rng(2);
  DetectionSet set{.utime = 1,
                   .seq = 2,
                   .channel = "DETECTIONS_PPF",
                   .camera = "XTION",
                   .image_seq = 3,
                   .estimator = "ppf",
                   .T_world_camera = RandomPose(rng),
                   .compute_time = 0.5,
                   .num_clusters = 4,
                   .detections = {}};
  for (int i = 0; i < 3; ++i) {
    set.detections.push_back({.model_id = "mug_" + std::to_string(i),
                              .cluster = i,
                              .touches_border = i == 1,
                              .T_camera_object = RandomPose(rng),
                              .covariance = RandomCovariance(rng),
                              .mse = 1e-6,
                              .inlier_fraction = 0.75,
                              .verification_score = 0.5});
  }
  return set;
}

TEST(DetectionConversion, RoundTripsOverTheWire) {
  const DetectionSet set = SomeDetections();
  const Result<detections_v2_t> message =
      DecodeChecked<detections_v2_t>(Encode(DetectionsToMessage(set)));
  ASSERT_TRUE(message.ok()) << message.error().message;
  const Result<DetectionSet> result = DetectionsFromMessage(message.value(), "DETECTIONS_PPF");
  ASSERT_TRUE(result.ok()) << result.error().message;
  const DetectionSet& back = *result;
  EXPECT_EQ(back.utime, 1);
  EXPECT_EQ(back.seq, 2);
  EXPECT_EQ(back.channel, "DETECTIONS_PPF");
  EXPECT_EQ(back.camera, "XTION");
  EXPECT_EQ(back.image_seq, 3);
  EXPECT_EQ(back.estimator, "ppf");
  EXPECT_EQ(back.compute_time, 0.5);
  EXPECT_EQ(back.num_clusters, 4);
  EXPECT_TRUE(back.T_world_camera.isApprox(set.T_world_camera, 1e-12));
  ASSERT_EQ(back.detections.size(), 3U);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back.detections[i].model_id, set.detections[i].model_id);
    EXPECT_EQ(back.detections[i].cluster, set.detections[i].cluster);
    EXPECT_EQ(back.detections[i].touches_border, i == 1);
    EXPECT_EQ(back.detections[i].covariance, set.detections[i].covariance);
    EXPECT_EQ(back.detections[i].mse, 1e-6);
    EXPECT_EQ(back.detections[i].inlier_fraction, 0.75);
    EXPECT_EQ(back.detections[i].verification_score, 0.5);
    EXPECT_TRUE(
        back.detections[i].T_camera_object.isApprox(set.detections[i].T_camera_object, 1e-12));
  }
}

TEST(DetectionConversion, EmptyIsNormal) {
  DetectionSet set = SomeDetections();
  set.detections.clear();
  const Result<DetectionSet> back = DetectionsFromMessage(DetectionsToMessage(set), "D");
  ASSERT_TRUE(back.ok());
  EXPECT_TRUE(back->detections.empty());
}

TEST(DetectionConversion, RefusesHostileValues) {
  const std::vector<std::function<void(detections_v2_t*)>> attacks = {
      [](detections_v2_t* m) { m->utime = kMinTime; },
      [](detections_v2_t* m) { m->utime = kMaxTime; },
      [](detections_v2_t* m) { m->camera = "../XTION"; },
      [](detections_v2_t* m) { m->estimator = std::string(65, 'a'); },
      [](detections_v2_t* m) { m->camera_quat[2] = kNan; },
      [](detections_v2_t* m) { m->compute_time = -1.0; },
      [](detections_v2_t* m) { m->compute_time = kNan; },
      [](detections_v2_t* m) { m->num_clusters = -1; },
      [](detections_v2_t* m) { m->detections.resize(10'001, m->detections[0]); },
      [](detections_v2_t* m) { m->detections[1].model_id = ""; },
      [](detections_v2_t* m) { m->detections[1].model_id = "a/b"; },
      [](detections_v2_t* m) { m->detections[1].cluster = -1; },
      [](detections_v2_t* m) { m->detections[1].quat[0] = 5.0; },
      [](detections_v2_t* m) { m->detections[1].trans[0] = kInf; },
      [](detections_v2_t* m) { m->detections[1].covariance[0] = -1e-9; },
      [](detections_v2_t* m) { m->detections[1].covariance[35] = kNan; },
      [](detections_v2_t* m) { m->detections[1].covariance[7] = kInf; },
      [](detections_v2_t* m) { m->detections[1].covariance[1] += 1.0; },
      [](detections_v2_t* m) {
        m->detections[1].covariance[1] = m->detections[1].covariance[6] = 1e9;
      },
      [](detections_v2_t* m) { m->detections[1].mse = -1e-9; },
      [](detections_v2_t* m) { m->detections[1].mse = kInf; },
      [](detections_v2_t* m) { m->detections[1].inlier_fraction = kNan; },
      [](detections_v2_t* m) { m->detections[1].inlier_fraction = 1.1; },
      [](detections_v2_t* m) { m->detections[1].verification_score = -0.1; }};
  for (size_t i = 0; i < attacks.size(); ++i) {
    detections_v2_t message = DetectionsToMessage(SomeDetections());
    attacks[i](&message);
    EXPECT_FALSE(DetectionsFromMessage(message, "D").ok()) << i;
  }
}

}  // namespace
}  // namespace vantage
