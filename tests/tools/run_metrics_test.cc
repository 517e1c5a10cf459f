#include "tools/support/run_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "common/rng.h"
#include "tests/tools/run_fixtures.h"

namespace vantage {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Pose RandomPose(Rng& rng) {
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  pose.translation() = rng.UnitVector();
  return pose;
}

// "part" has no symmetry, "nut" six-fold about z through a center that is not its origin.
ReportSetup TwoModels() {
  ReportSetup setup;
  setup.camera = "A";
  setup.models["part"] = PlainModel("part", {0.01, -0.02, 0.03}, 0.1);
  setup.models["nut"] =
      PlainModel("nut", {0.0, 0.04, 0.01}, 0.06, SymmetryGroup::Cyclic(6, {0.0, 0.0, 1.0}));
  return setup;
}

RecordedRun RunOf(std::vector<object_estimate_v3_t> objects) {
  RecordedRun run;
  run.views.push_back(ViewOf(0.0, std::move(objects), 0));
  return run;
}

TEST(ErrorOf, IsTheTurnAboutTheCenterAndItsShift) {
  Rng rng(1);
  const ObjectModel part = TwoModels().models.at("part");
  for (int i = 0; i < 100; ++i) {
    const Pose truth = RandomPose(rng);
    const double angle = rng.Uniform(0.0, std::numbers::pi);
    const Eigen::Vector3d shift = rng.Uniform(0.0, 0.05) * rng.UnitVector();
    const PoseError error =
        ErrorOf(part, OffBy(truth, part, angle, shift, rng.UnitVector()), truth);
    EXPECT_NEAR(error.angle, angle, 1e-7);
    EXPECT_NEAR(error.distance, shift.norm(), 1e-12);
  }
}

TEST(ErrorOf, IsModuloTheModelsSymmetry) {
  Rng rng(2);
  const ObjectModel nut = TwoModels().models.at("nut");
  const ObjectModel bottle =
      PlainModel("bottle", {0.0, 0.0, 0.1}, 0.2, SymmetryGroup::Continuous({0, 0, 1}, false));
  for (int i = 0; i < 60; ++i) {
    const Pose truth = RandomPose(rng);
    // A turn about the axis, then a little one about another: only the little one counts.
    const Pose equal = OffBy(truth, nut, i * std::numbers::pi / 3.0, {0, 0, 0}, {0, 0, 1});
    EXPECT_NEAR(ErrorOf(nut, equal, truth).angle, 0.0, 1e-7);
    EXPECT_NEAR(ErrorOf(nut, equal, truth).distance, 0.0, 1e-12);
    const PoseError off = ErrorOf(nut, OffBy(equal, nut, 0.1, {0, 0.002, 0}, {1, 0, 0}), truth);
    EXPECT_NEAR(off.angle, 0.1, 1e-7);
    EXPECT_NEAR(off.distance, 0.002, 1e-12);
    const Pose turned =
        OffBy(truth, bottle, rng.Uniform(0.0, 6.0), Eigen::Vector3d::Zero(), {0, 0, 1});
    EXPECT_NEAR(ErrorOf(bottle, turned, truth).angle, 0.0, 1e-7);
  }
  // Half a step about the axis is as far as it gets.
  const Pose half = OffBy(Pose::Identity(), nut, std::numbers::pi / 6.0, {0, 0, 0}, {0, 0, 1});
  EXPECT_NEAR(ErrorOf(nut, half, Pose::Identity()).angle, std::numbers::pi / 6.0, 1e-9);
}

TEST(RunMetrics, FollowsKnownErrorsThroughTheViews) {
  ReportSetup setup = TwoModels();
  Rng rng(3);
  const Pose truth = RandomPose(rng);
  setup.truth = {{"part", truth}};
  const ObjectModel& part = setup.models.at("part");
  const double fused_deg[] = {8.0, 3.0, 1.0, 0.5};
  const double single_deg[] = {8.0, 20.0, 0.0, 2.0};  // Not detected in the third.
  RecordedRun run;
  for (int i = 0; i < 4; ++i) {
    object_estimate_v3_t object = EstimateAt(
        7, "part", OffBy(truth, part, fused_deg[i] * kDegree, {0.0, 0.001 * (4 - i), 0.0}));
    object.converged = i >= 2 ? 1 : 0;
    object.num_views = i < 2 ? i + 1 : i;
    RunView view = ViewOf(2.5 * i, {object}, i);
    if (i != 2) {
      view.detections[7] = OffBy(truth, part, single_deg[i] * kDegree, {0.003, 0.0, 0.0});
    }
    run.views.push_back(view);
  }
  const RunMetrics metrics = MeasureRun(run, setup);
  ASSERT_EQ(metrics.objects.size(), 1U);
  EXPECT_TRUE(metrics.extra.empty());
  const ObjectHistory& history = metrics.objects[0];
  EXPECT_EQ(history.model_id, "part");
  EXPECT_EQ(history.instance, 7);
  EXPECT_EQ(history.num_views, 3);
  EXPECT_TRUE(history.converged);
  EXPECT_DOUBLE_EQ(history.seconds, 5.0);
  ASSERT_EQ(history.fused.size(), 4U);
  ASSERT_EQ(history.detected.size(), 4U);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(history.fused[i].value().angle, fused_deg[i] * kDegree, 1e-7);
    EXPECT_NEAR(history.fused[i].value().distance, 0.001 * static_cast<double>(4 - i), 1e-12);
    ASSERT_EQ(history.detected[i].has_value(), i != 2);
    if (i == 2) continue;
    EXPECT_NEAR(history.detected[i]->angle, single_deg[i] * kDegree, 1e-7);
    EXPECT_NEAR(history.detected[i]->distance, 0.003, 1e-12);
  }
  EXPECT_NEAR(history.final_error().value().angle, 0.5 * kDegree, 1e-7);
  EXPECT_NEAR(history.median_detection_angle().value(), 8.0 * kDegree, 1e-7);
  EXPECT_TRUE(metrics.Within(0.51 * kDegree, 0.0011));
  EXPECT_FALSE(metrics.Within(0.49 * kDegree, 0.0011));
  EXPECT_FALSE(metrics.Within(0.51 * kDegree, 0.0009));
}

TEST(RunMetrics, ViewsWithoutAKnownTimeDoNotCountAsSeconds) {
  ReportSetup setup = TwoModels();
  setup.truth = {{"part", Pose::Identity()}};
  RecordedRun run;
  for (int i = 0; i < 4; ++i) {
    run.views.push_back(ViewOf(i, {EstimateAt(1, "part", Pose::Identity())}, i));
  }
  run.views[0].utime = 0;
  run.views[3].utime = 0;
  EXPECT_DOUBLE_EQ(MeasureRun(run, setup).objects[0].seconds, 1.0);
}

TEST(RunMetrics, MissingObjectIsNotWithin) {
  ReportSetup setup = TwoModels();
  setup.truth = {{"part", Pose::Identity()}, {"nut", Pose(Eigen::Translation3d(0.3, 0.0, 0.0))}};
  const RunMetrics metrics = MeasureRun(RunOf({EstimateAt(1, "part", Pose::Identity())}), setup);
  ASSERT_EQ(metrics.objects.size(), 2U);
  EXPECT_TRUE(metrics.objects[0].final_error().has_value());
  EXPECT_FALSE(metrics.objects[1].instance.has_value());
  EXPECT_FALSE(metrics.objects[1].final_error().has_value());
  EXPECT_FALSE(metrics.objects[1].median_detection_angle().has_value());
  EXPECT_FALSE(metrics.Within(3.2, 1.0));
}

TEST(RunMetrics, ExtraConfirmedObjectIsNotWithin) {
  ReportSetup setup = TwoModels();
  setup.truth = {{"part", Pose::Identity()}};
  object_estimate_v3_t ghost = EstimateAt(2, "nut", Pose::Identity());
  const object_estimate_v3_t part = EstimateAt(1, "part", Pose::Identity());
  RunMetrics metrics = MeasureRun(RunOf({part, ghost}), setup);
  EXPECT_EQ(metrics.extra, (std::vector<std::string>{"nut 2"}));
  EXPECT_EQ(metrics.objects.size(), 1U);
  EXPECT_FALSE(metrics.Within(0.1, 0.1));
  // What is not yet, or no longer, believed is no claim.
  for (const int8_t state : {object_estimate_v3_t::TENTATIVE, object_estimate_v3_t::LOST}) {
    ghost.state = state;
    metrics = MeasureRun(RunOf({part, ghost}), setup);
    EXPECT_TRUE(metrics.extra.empty());
    EXPECT_TRUE(metrics.Within(0.1, 0.1));
  }
}

TEST(RunMetrics, TwoInstancesOfOneModelGoWithTheNearest) {
  ReportSetup setup = TwoModels();
  const ObjectModel& part = setup.models.at("part");
  const Pose here(Eigen::Translation3d(0.0, 0.0, 0.0));
  const Pose there(Eigen::Translation3d(0.04, 0.0, 0.0));  // Within half a diameter of each other.
  setup.truth = {{"part", here}, {"part", there}};
  const std::vector<object_estimate_v3_t> estimates = {
      EstimateAt(5, "part", OffBy(there, part, 0.01, {0.001, 0.0, 0.0})),
      EstimateAt(9, "part", OffBy(here, part, 0.02, {0.002, 0.0, 0.0}))};
  for (const bool turned : {false, true}) {
    std::vector<object_estimate_v3_t> listed = estimates;
    if (turned) std::swap(listed[0], listed[1]);
    const RunMetrics metrics = MeasureRun(RunOf(listed), setup);
    ASSERT_EQ(metrics.objects.size(), 2U);
    EXPECT_EQ(metrics.objects[0].instance, 9);
    EXPECT_EQ(metrics.objects[1].instance, 5);
    EXPECT_NEAR(metrics.objects[0].final_error().value().angle, 0.02, 1e-7);
    EXPECT_NEAR(metrics.objects[1].final_error().value().angle, 0.01, 1e-7);
    EXPECT_TRUE(metrics.Within(0.03, 0.003));
  }
  // One estimate for two objects: one of them is missing. A third is one too many.
  EXPECT_FALSE(MeasureRun(RunOf({estimates[0]}), setup).Within(0.03, 0.003));
  EXPECT_FALSE(MeasureRun(RunOf({estimates[0]}), setup).objects[0].instance.has_value());
  EXPECT_EQ(MeasureRun(RunOf({estimates[0]}), setup).objects[1].instance, 5);
  const auto three =
      MeasureRun(RunOf({estimates[0],
                        estimates[1],
                        EstimateAt(11, "part", OffBy(here, part, 0.0, {0.02, 0, 0}))}),
                 setup);
  EXPECT_EQ(three.extra, (std::vector<std::string>{"part 11"}));
}

TEST(RunMetrics, FartherThanHalfTheDiameterIsAnotherObject) {
  ReportSetup setup = TwoModels();
  setup.truth = {{"part", Pose::Identity()}};
  const ObjectModel& part = setup.models.at("part");
  const auto at = [&](double distance) {
    return MeasureRun(
        RunOf({EstimateAt(1, "part", OffBy(Pose::Identity(), part, 0.0, {0, distance, 0}))}),
        setup);
  };
  EXPECT_EQ(at(0.0499).objects[0].instance, 1);
  EXPECT_FALSE(at(0.0501).objects[0].instance.has_value());
  EXPECT_EQ(at(0.0501).extra.size(), 1U);
  // Nor is one of another model, however near.
  const RunMetrics other = MeasureRun(RunOf({EstimateAt(1, "nut", Pose::Identity())}), setup);
  EXPECT_FALSE(other.objects[0].instance.has_value());
  // A model that nobody knows is told, not judged.
  const RunMetrics unknown = MeasureRun(RunOf({EstimateAt(3, "cup", Pose::Identity())}), setup);
  EXPECT_EQ(unknown.extra, (std::vector<std::string>{"cup 3"}));
}

TEST(RunMetrics, WithoutTruthObjectsHaveNoErrors) {
  const RunMetrics metrics =
      MeasureRun(RunOf({EstimateAt(1, "part", Pose::Identity())}), TwoModels());
  ASSERT_EQ(metrics.objects.size(), 1U);
  EXPECT_EQ(metrics.objects[0].instance, 1);
  EXPECT_FALSE(metrics.objects[0].final_error().has_value());
  EXPECT_TRUE(metrics.extra.empty());
  EXPECT_FALSE(metrics.Within(10.0, 10.0));
}

TEST(RunMetrics, PosesThatAreNoneAreNoEstimates) {
  ReportSetup setup = TwoModels();
  setup.truth = {{"part", Pose::Identity()}};
  object_estimate_v3_t object = EstimateAt(1, "part", Pose::Identity());
  object.trans[1] = kNan;
  EXPECT_FALSE(EstimatedPose(object).has_value());
  EXPECT_FALSE(MeasureRun(RunOf({object}), setup).Within(10.0, 10.0));
  object = EstimateAt(1, "part", Pose::Identity());
  object.peaks[0].quat[0] = 0.0;
  EXPECT_FALSE(EstimatedPose(object).has_value());
  object.peaks.clear();
  EXPECT_FALSE(EstimatedPose(object).has_value());
  EXPECT_FALSE(MeasureRun(RunOf({object}), setup).Within(10.0, 10.0));
}

TEST(RunMetrics, WhatIsNotANumberIsNotWithin) {
  RunMetrics metrics;
  EXPECT_FALSE(metrics.Within(1.0, 1.0)) << "nothing at all";
  metrics.objects.resize(2);
  for (ObjectHistory& object : metrics.objects) object.fused = {PoseError{0.1, 0.1}};
  EXPECT_TRUE(metrics.Within(1.0, 1.0));
  for (const PoseError bad : {PoseError{kNan, 0.0}, PoseError{0.0, kNan}}) {
    metrics.objects[1].fused.back() = bad;
    EXPECT_FALSE(metrics.Within(1.0, 1.0));
  }
  metrics.objects[1].fused.back().reset();
  EXPECT_FALSE(metrics.Within(1.0, 1.0));
}

TEST(RunMetrics, BetterThanTheMedianDetectionIsEveryObject) {
  RunMetrics metrics;
  metrics.objects.resize(2);
  for (ObjectHistory& object : metrics.objects) {
    object.detected = {PoseError{0.3, 0.0}, PoseError{0.1, 0.0}, PoseError{0.2, 0.0}};
    object.fused = {PoseError{0.5, 0.0}, PoseError{0.5, 0.0}, PoseError{0.19, 0.0}};
  }
  EXPECT_TRUE(metrics.BetterThanMedianDetection());
  for (const double angle : {0.2, 0.25, kNan}) {
    metrics.objects[1].fused.back() = PoseError{angle, 0.0};
    EXPECT_FALSE(metrics.BetterThanMedianDetection()) << angle;
  }
  metrics.objects[1].fused.back().reset();
  EXPECT_FALSE(metrics.BetterThanMedianDetection());
  metrics.objects[1].fused.back() = PoseError{0.1, 0.0};
  metrics.objects[1].detected.clear();
  EXPECT_FALSE(metrics.BetterThanMedianDetection());
}

TEST(RunMetrics, MedianHasAsManyBelowAsAbove) {
  Rng rng(4);
  for (int count = 1; count < 12; ++count) {
    ObjectHistory history;
    for (int i = 0; i < count; ++i) {
      history.detected.emplace_back(PoseError{rng.Uniform(0.0, 1.0), 0.0});
      if (i % 3 == 0) history.detected.emplace_back(std::nullopt);
    }
    const double median = history.median_detection_angle().value();
    int below = 0;
    int above = 0;
    for (const auto& error : history.detected) {
      if (!error) continue;
      below += error->angle < median ? 1 : 0;
      above += error->angle > median ? 1 : 0;
    }
    EXPECT_EQ(below, count / 2);
    EXPECT_EQ(above, count / 2);
  }
  ObjectHistory two;
  two.detected = {PoseError{0.4, 0.0}, PoseError{0.2, 0.0}};
  EXPECT_DOUBLE_EQ(two.median_detection_angle().value(), 0.3);
}

}  // namespace
}  // namespace vantage
