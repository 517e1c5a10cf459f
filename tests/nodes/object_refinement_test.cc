// Refinement in the node: which images are kept, which objects are refined, what is published.
#include "nodes/object_refinement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "bus/image_conversion.h"
#include "common/depth_rasterizer.h"
#include "nodes/fusion_messages.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000;
constexpr int kViews = 5;

ObjectModel Model() {
  ObjectModel model;
  model.id = "part";
  model.mesh = MakeAsymmetric();
  model.center = Eigen::Vector3d(0.05, 0.03, 0.03);
  model.diameter = 0.14;
  return model;
}

/// Five views of one object, and a fused estimate of it that is off by 0.5 degrees and 1 mm.
class ObjectRefinementTest : public testing::Test {
 protected:
  ObjectRefinementTest()
      : models_{{"part", std::make_shared<const RefinedModel>(Model())}},
        refinement_(Config(), models_) {
    truth_.linear() = ExpSo3({0.1, -0.2, 0.7}).toRotationMatrix();
    truth_.translation() = Eigen::Vector3d(-0.02, 0.01, 0.05);
    refinement_.OnCamera(SmallCamera());
    estimate_.instance_id = 3;
    estimate_.model_id = "part";
    estimate_.state = ObjectEstimate::State::kConfirmed;
    estimate_.peaks.resize(1);
    estimate_.peaks[0].weight = 0.8;
    Pose off = Pose::Identity();
    off.linear() = ExpSo3(0.5 * kDegree * Eigen::Vector3d(0.6, 0.0, 0.8)).toRotationMatrix();
    off.translation() =
        Eigen::Vector3d(0.0006, 0.0, 0.0008) + Model().center - off.linear() * Model().center;
    estimate_.T_world_object = truth_ * off;
  }

  static ObjectRefinementConfig Config() {
    ObjectRefinementConfig config;
    config.camera = "XTION";
    config.parameters.min_views = 3;
    return config;
  }

  static int64_t Utime(int view) { return kStart + 1'000'000 * view; }

  Pose CameraOf(int view) const {
    const double azimuth = 1.2 * view;
    return LookAt(truth_ * Model().center +
                      Eigen::Vector3d(0.4 * std::cos(azimuth), 0.4 * std::sin(azimuth), 0.4),
                  truth_ * Model().center);
  }

  void SendImage(int view) {
    const Pose T_camera_object = CameraOf(view).inverse() * truth_;
    DepthRasterizer rasterizer(SmallCamera());
    rasterizer.Clear();
    rasterizer.Draw(Model().mesh, T_camera_object);
    const DepthImage image = ToImage(rasterizer);
    refinement_.OnImages(DepthToMessage(image.width,
                                        image.height,
                                        DepthToMillimetres(image),
                                        Utime(view),
                                        view,
                                        "",
                                        DepthCompression::kZlib));
  }

  DetectionSet Set(int view) const {
    DetectionSet set;
    set.utime = Utime(view);
    set.camera = "XTION";
    set.T_world_camera = CameraOf(view);
    return set;
  }

  // The object is seen from one more view.
  Result<void> See(int view) {
    Observation observation;
    observation.viewpoint = view;
    observation.source.utime = Utime(view);
    estimate_.observations.push_back(observation);
    return refinement_.OnSet(Set(view), {&estimate_, 1});
  }

  double AngleOff(const Pose& pose) const {
    return GeodesicAngle(Eigen::Quaterniond(pose.linear()), Eigen::Quaterniond(truth_.linear()));
  }

  ObjectRefinement::Models models_;
  ObjectRefinement refinement_;
  Pose truth_ = Pose::Identity();
  ObjectEstimate estimate_;
};

TEST_F(ObjectRefinementTest, RefinesOnceEnoughImagesShowIt) {
  for (int view = 0; view < kViews; ++view) {
    SendImage(view);
    ASSERT_TRUE(See(view));
    EXPECT_EQ(refinement_.refined().size(), view < 2 ? 0U : 1U) << view;
  }
  const MultiViewRefined& refined = refinement_.refined().at(3);
  ASSERT_TRUE(refined.is_refined) << refined.note;
  EXPECT_EQ(refined.views, kViews);
  EXPECT_LT(AngleOff(refined.T_world_object), 0.1 * kDegree);
  EXPECT_GT(AngleOff(estimate_.T_world_object), 0.4 * kDegree);

  object_estimates_v3_t message = ObjectsToMessage({&estimate_, 1});
  object_estimate_v3_t& object = message.objects.front();
  EXPECT_EQ(object.refinement, object_estimate_v3_t::NOT_REFINED);
  EXPECT_NEAR(object.refined_trans[0], estimate_.T_world_object.translation().x(), 1e-12);
  AddRefinement(refined, &object);
  EXPECT_EQ(object.refinement, object_estimate_v3_t::REFINED);
  EXPECT_EQ(object.refined_views, kViews);
  const Result<Pose> told = PoseFromWire(object.refined_trans, object.refined_quat);
  ASSERT_TRUE(told);
  EXPECT_TRUE(told->isApprox(refined.T_world_object, 1e-9));
  for (int i = 0; i < 36; ++i) {
    EXPECT_EQ(object.refined_covariance[i], refined.covariance(i / 6, i % 6));
  }
}

TEST_F(ObjectRefinementTest, WaitsUntilTheModeIsSettled) {
  estimate_.peaks.resize(2);
  estimate_.peaks[1].weight = 0.3;
  for (int view = 0; view < kViews; ++view) {
    SendImage(view);
    ASSERT_TRUE(See(view));
  }
  EXPECT_TRUE(refinement_.refined().empty());
  estimate_.peaks[1].weight = 0.05;
  ASSERT_TRUE(refinement_.OnSet(Set(kViews - 1), {&estimate_, 1}));
  EXPECT_EQ(refinement_.refined().size(), 1U);
  estimate_.state = ObjectEstimate::State::kTentative;
  ASSERT_TRUE(refinement_.OnSet(Set(kViews - 1), {&estimate_, 1}));
  EXPECT_TRUE(refinement_.refined().empty());
}

TEST_F(ObjectRefinementTest, ImagesThatNeverCameAreMissedAndNoMore) {
  for (int view = 0; view < kViews; ++view) {
    if (view != 1) SendImage(view);
    ASSERT_TRUE(See(view));
  }
  ASSERT_EQ(refinement_.refined().size(), 1U);
  EXPECT_EQ(refinement_.refined().at(3).views, kViews - 1);
}

TEST_F(ObjectRefinementTest, AnotherCalibrationForgetsImages) {
  for (int view = 0; view < kViews; ++view) {
    SendImage(view);
    ASSERT_TRUE(See(view));
  }
  CameraModel other = SmallCamera();
  other.fx += 1.0;
  refinement_.OnCamera(other);
  ASSERT_TRUE(refinement_.OnSet(Set(0), {&estimate_, 1}));
  EXPECT_TRUE(refinement_.refined().empty());
}

TEST_F(ObjectRefinementTest, OfAnotherCameraNothingIsKept) {
  for (int view = 0; view < kViews; ++view) {
    SendImage(view);
    Observation observation;
    observation.source.utime = Utime(view);
    estimate_.observations.push_back(observation);
    DetectionSet set = Set(view);
    set.camera = "OTHER";
    ASSERT_TRUE(refinement_.OnSet(set, {&estimate_, 1}));
  }
  EXPECT_TRUE(refinement_.refined().empty());
}

TEST_F(ObjectRefinementTest, ADamagedImageIsToldAndTheRestIsRefined) {
  for (int view = 0; view < kViews; ++view) {
    SendImage(view);
    if (view == kViews - 1) {
      images_t damaged{};
      damaged.utime = Utime(kViews);
      refinement_.OnImages(damaged);
    }
    ASSERT_TRUE(See(view));
  }
  EXPECT_FALSE(See(kViews));
  ASSERT_EQ(refinement_.refined().size(), 1U);
  EXPECT_EQ(refinement_.refined().at(3).views, kViews);
}

}  // namespace
}  // namespace vantage
