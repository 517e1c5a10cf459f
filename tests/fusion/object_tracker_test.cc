#include "fusion/object_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

const So3Grid& Grid() {
  static const So3Grid grid(32);
  return grid;
}

const std::map<std::string, TrackedModel>& Models() {
  static const std::map<std::string, TrackedModel> models = {
      {"mug", {Eigen::Vector3d(0.0, 0.0, 0.05), 0.12}},
      {"filter", {Eigen::Vector3d(0.01, 0.0, 0.04), 0.10}}};
  return models;
}

ObjectTracker MakeTracker() { return ObjectTracker(Grid(), {}, Models()); }

Pose At(double x, double y, double yaw_deg) {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3(Eigen::Vector3d(0.0, 0.0, yaw_deg * kDegree)).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x, y, 0.0);
  return pose;
}

Pose Camera(double azimuth_deg, double elevation_deg = 45.0) {
  const double a = azimuth_deg * kDegree;
  const double e = elevation_deg * kDegree;
  const Eigen::Vector3d eye(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e));
  return LookAt(0.75 * eye, Eigen::Vector3d::Zero());
}

// Sets of detections as an estimator would send them.
class Estimator {
 public:
  DetectionSet Set(const Pose& T_world_camera) {
    DetectionSet set;
    set.channel = "DETECTIONS_PPF";
    set.seq = seq_;
    set.utime = 1'000'000 + 100'000 * seq_;
    ++seq_;
    set.T_world_camera = T_world_camera;
    return set;
  }

  static void Detect(DetectionSet* set,
                     const std::string& model,
                     const Pose& T_world_object,
                     double score = 0.9,
                     double mse = 1e-6) {
    Detection detection;
    detection.model_id = model;
    detection.cluster = static_cast<int>(set->detections.size());
    detection.T_camera_object = set->T_world_camera.inverse() * T_world_object;
    detection.mse = mse;
    detection.verification_score = score;
    set->detections.push_back(detection);
  }

 private:
  int64_t seq_ = 0;
};

TEST(Viewpoints, SamePlaceIsOneViewpoint) {
  const ViewpointParameters parameters;
  std::vector<Viewpoint> viewpoints = {{Camera(0.0), 1}, {Camera(40.0), 1}};
  EXPECT_EQ(FindViewpoint(viewpoints, Camera(1.0), parameters), 0);
  EXPECT_EQ(FindViewpoint(viewpoints, Camera(41.0), parameters), 1);
  EXPECT_EQ(FindViewpoint(viewpoints, Camera(20.0), parameters), -1);
  Pose rolled = Camera(0.0);
  rolled.rotate(ExpSo3(Eigen::Vector3d(0.0, 0.0, 1.0)));
  EXPECT_EQ(FindViewpoint(viewpoints, rolled, parameters), 0);
  Pose turned = Camera(0.0);
  turned.rotate(ExpSo3(Eigen::Vector3d(0.0, 6.0 * kDegree, 0.0)));
  EXPECT_EQ(FindViewpoint(viewpoints, turned, parameters), -1);
  Pose moved = Camera(0.0);
  moved.pretranslate(Eigen::Vector3d(0.0, 0.0, 0.06));
  EXPECT_EQ(FindViewpoint(viewpoints, moved, parameters), -1);
}

TEST(ObjectTracker, FusesViewsIntoThePoseOfTheModelsOrigin) {
  Rng rng(1);
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  const Pose truth = At(0.1, -0.05, 70.0);
  for (int view = 0; view < 6; ++view) {
    DetectionSet set = estimator.Set(Camera(60.0 * view));
    Pose detected = truth;
    detected.rotate(ExpSo3(kDegree * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal())));
    // Turned about the center, as an estimator that aligns surfaces errs.
    detected.translation() =
        truth * Models().at("mug").center - detected.linear() * Models().at("mug").center;
    Estimator::Detect(&set, "mug", detected);
    const ObjectTracker::Update update = tracker.Add(set);
    EXPECT_TRUE(update.used && update.changed);
    EXPECT_EQ(update.viewpoint, view);
  }
  const std::vector<ObjectEstimate> estimates = tracker.Estimates();
  ASSERT_EQ(estimates.size(), 1U);
  const ObjectEstimate& mug = estimates.front();
  EXPECT_EQ(mug.state, ObjectEstimate::State::kConfirmed);
  EXPECT_EQ(mug.observations.size(), 6U);
  EXPECT_LT((mug.center_world - truth * Models().at("mug").center).norm(), 1e-6);
  EXPECT_LT((mug.T_world_object.translation() - truth.translation()).norm(), 0.002);
  EXPECT_LT(GeodesicAngle(Eigen::Quaterniond(mug.T_world_object.linear()),
                          Eigen::Quaterniond(truth.linear())),
            1.5 * kDegree);
}

TEST(ObjectTracker, FramesFromOnePlaceCountOnceAndTheBestOneStays) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  for (const double score : {0.5, 0.9, 0.7}) {
    DetectionSet set = estimator.Set(Camera(10.0));
    Estimator::Detect(&set, "mug", At(0.0, 0.0, 100.0 * score), score);
    EXPECT_EQ(tracker.Add(set).changed, score > 0.4 && score != 0.7);
  }
  ASSERT_EQ(tracker.Estimates().size(), 1U);
  const ObjectEstimate mug = tracker.Estimates().front();
  ASSERT_EQ(mug.observations.size(), 1U);
  EXPECT_EQ(mug.observations.front().source.seq, 1);
  EXPECT_NEAR(mug.histogram->Mass(), mug.verification_weight, 1e-9);
  EXPECT_EQ(mug.state, ObjectEstimate::State::kTentative);
  EXPECT_EQ(tracker.state().viewpoints.front().num_sets, 3);
}

TEST(ObjectTracker, ASetSentAgainIsIgnored) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  DetectionSet set = estimator.Set(Camera(0.0));
  EXPECT_TRUE(tracker.Add(set).used);
  EXPECT_FALSE(tracker.Add(set).used);
  set.utime += 1;  // Of an estimator that was started again.
  EXPECT_TRUE(tracker.Add(set).used);
}

TEST(ObjectTracker, InstancesOfAModelAreToldApartByPosition) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  for (int view = 0; view < 3; ++view) {
    DetectionSet set = estimator.Set(Camera(50.0 * view));
    const double shift = 0.01 * view;
    if (view != 1) Estimator::Detect(&set, "mug", At(0.2 + shift, 0.0, 0.0));
    Estimator::Detect(&set, "mug", At(shift, 0.0, 90.0));
    if (view == 2) Estimator::Detect(&set, "filter", At(-0.2, 0.1, 0.0));
    tracker.Add(set);
  }
  const std::vector<ObjectEstimate> estimates = tracker.Estimates();
  ASSERT_EQ(estimates.size(), 3U);
  EXPECT_EQ(estimates[0].instance_id, 0);
  EXPECT_EQ(estimates[0].observations.size(), 2U);
  EXPECT_EQ(estimates[1].observations.size(), 3U);
  EXPECT_EQ(estimates[2].model_id, "filter");
  EXPECT_EQ(estimates[2].state, ObjectEstimate::State::kTentative);
}

TEST(ObjectTracker, HypothesesOfOneClusterExcludeEachOther) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  DetectionSet set = estimator.Set(Camera(0.0));
  Estimator::Detect(&set, "mug", At(0.0, 0.0, 0.0), 0.6);
  Estimator::Detect(&set, "filter", At(0.0, 0.0, 0.0), 0.8);
  Estimator::Detect(&set, "mug", At(0.3, 0.0, 0.0), 0.3);
  for (Detection& detection : set.detections) detection.cluster = 4;
  tracker.Add(set);
  ASSERT_EQ(tracker.Estimates().size(), 1U);
  EXPECT_EQ(tracker.Estimates().front().model_id, "filter");
}

TEST(ObjectTracker, OfTwoModelsInOnePlaceTheBetterSupportedIsReported) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  for (int view = 0; view < 5; ++view) {
    DetectionSet set = estimator.Set(Camera(40.0 * view));
    Estimator::Detect(&set, view < 2 ? "filter" : "mug", At(0.0, 0.0, 0.0));
    tracker.Add(set);
    ASSERT_EQ(tracker.Estimates().size(), 1U) << view;
  }
  EXPECT_EQ(tracker.Estimates().front().model_id, "mug");
}

TEST(ObjectTracker, AnObjectSeenOnceIsLostAfterAWhile) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  DetectionSet first = estimator.Set(Camera(0.0));
  Estimator::Detect(&first, "mug", At(0.0, 0.0, 0.0));
  tracker.Add(first);
  for (int view = 1; view <= 3; ++view) {
    EXPECT_EQ(tracker.Estimates().front().state, ObjectEstimate::State::kTentative);
    tracker.Add(estimator.Set(Camera(50.0 * view)));
  }
  EXPECT_EQ(tracker.Estimates().front().state, ObjectEstimate::State::kLost);
  DetectionSet again = estimator.Set(Camera(250.0));
  Estimator::Detect(&again, "mug", At(0.0, 0.0, 0.0));
  tracker.Add(again);
  EXPECT_EQ(tracker.Estimates().front().state, ObjectEstimate::State::kConfirmed);
}

TEST(ObjectTracker, InvalidInputIsDroppedAndCounted) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  DetectionSet set = estimator.Set(Camera(0.0));
  Estimator::Detect(&set, "teapot", At(0.0, 0.0, 0.0));
  Estimator::Detect(&set, "mug", At(kNan, 0.0, 0.0));
  Estimator::Detect(&set, "mug", At(0.0, 0.0, 0.0), 0.9, kNan);
  Estimator::Detect(&set, "mug", At(0.0, 0.0, 0.0), 0.9, -1.0);
  Estimator::Detect(&set, "mug", At(0.0, 0.0, 0.0), kNan);
  Estimator::Detect(&set, "mug", At(0.0, 0.0, 0.0));
  set.detections.back().T_camera_object.linear() *= 2.0;
  const ObjectTracker::Update update = tracker.Add(set);
  EXPECT_TRUE(update.used);
  EXPECT_EQ(update.num_invalid, 6);
  EXPECT_TRUE(tracker.Estimates().empty());

  DetectionSet lost = estimator.Set(Camera(0.0));
  lost.T_world_camera.translation().x() = kNan;
  EXPECT_FALSE(tracker.Add(lost).used);
}

TEST(ObjectTracker, HoweverBadAFitTheEstimateIsFinite) {
  const double sigma = OrientationFilterParameters().sigma_vw;
  for (double misfit = 0.0; misfit < 45.0; misfit += 0.5) {
    ObjectTracker tracker = MakeTracker();
    Estimator estimator;
    DetectionSet set = estimator.Set(Camera(0.0));
    Estimator::Detect(&set, "mug", At(0.0, 0.0, 0.0), 0.9, misfit * sigma);
    const ObjectTracker::Update update = tracker.Add(set);
    const std::vector<ObjectEstimate> estimates = tracker.Estimates();
    EXPECT_EQ(estimates.size() + static_cast<size_t>(update.num_invalid), 1U) << misfit;
    EXPECT_EQ(update.num_invalid, misfit < 6.4 ? 0 : 1) << misfit;
    for (const ObjectEstimate& estimate : estimates) {
      EXPECT_TRUE(estimate.center_covariance.allFinite()) << misfit;
      EXPECT_TRUE(estimate.T_world_object.matrix().allFinite()) << misfit;
    }
  }
}

TEST(ObjectTracker, ViewpointsBeyondTheMostAreDroppedAndCounted) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  Pose camera = Camera(0.0);
  for (size_t i = 0; i < ObjectTracker::kMostViewpoints; ++i) {
    camera.translation().x() += 1.0;
    ASSERT_TRUE(tracker.Add(estimator.Set(camera)).used);
  }
  camera.translation().x() += 1.0;
  const ObjectTracker::Update beyond = tracker.Add(estimator.Set(camera));
  EXPECT_FALSE(beyond.used);
  EXPECT_EQ(beyond.num_beyond, 1);
  EXPECT_EQ(tracker.state().viewpoints.size(), ObjectTracker::kMostViewpoints);
  // What is known goes on.
  camera.translation().x() -= 1.0;
  EXPECT_TRUE(tracker.Add(estimator.Set(camera)).used);
}

TEST(ObjectTracker, ObjectsBeyondTheMostAreDroppedAndCounted) {
  ObjectTracker tracker = MakeTracker();
  Estimator estimator;
  DetectionSet set = estimator.Set(Camera(0.0));
  for (size_t i = 0; i < ObjectTracker::kMostInstances + 3; ++i) {
    Estimator::Detect(&set, "mug", At(static_cast<double>(i), 0.0, 0.0));
  }
  const ObjectTracker::Update update = tracker.Add(set);
  EXPECT_TRUE(update.used);
  EXPECT_EQ(update.num_beyond, 3);
  EXPECT_EQ(tracker.state().instances.size(), ObjectTracker::kMostInstances);
  // Those that are known are still observed.
  set = estimator.Set(Camera(90.0));
  Estimator::Detect(&set, "mug", At(7.0, 0.0, 0.0));
  EXPECT_TRUE(tracker.Add(set).changed);
  EXPECT_EQ(tracker.state().instances[7].observations.size(), 2U);
}

// A tracker of one model, "part".
ObjectTracker TrackerOf(const SymmetryGroup& symmetry,
                        const std::vector<LikelyPose>& likely_poses = {},
                        double prior_uniform_share = 0.2) {
  ObjectTrackerParameters parameters;
  parameters.prior_uniform_share = prior_uniform_share;
  return ObjectTracker(Grid(),
                       parameters,
                       {{"part", {Eigen::Vector3d(0.0, 0.0, 0.05), 0.12, symmetry, likely_poses}}});
}

// Adds one view in which the part lies so.
void SeePart(const Eigen::Quaterniond& q, int view, Estimator* estimator, ObjectTracker* tracker) {
  DetectionSet set = estimator->Set(Camera(40.0 * view));
  Pose pose = Pose::Identity();
  pose.linear() = q.toRotationMatrix();
  pose.translation() = -(q * Eigen::Vector3d(0.0, 0.0, 0.05));
  Estimator::Detect(&set, "part", pose);
  ASSERT_TRUE(tracker->Add(set).changed);
}

Eigen::Quaterniond OrientationOf(const ObjectEstimate& estimate) {
  return Eigen::Quaterniond(estimate.T_world_object.linear());
}

TEST(ObjectTracker, ConvergesModuloTheModelsSymmetry) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, -0.2, 0.9).normalized();
  const Eigen::Quaterniond truth = ExpSo3(Eigen::Vector3d(0.4, 1.1, -0.3));
  for (const SymmetryGroup& symmetry :
       {SymmetryGroup::Continuous(axis, false), SymmetryGroup::Cyclic(4, axis)}) {
    const bool continuous = symmetry.kind == SymmetryGroup::Kind::kContinuous;
    Rng rng(5);
    Estimator estimator;
    ObjectTracker knowing = TrackerOf(symmetry);
    ObjectTracker unknowing = TrackerOf(SymmetryGroup::None());
    // Seen turned by this or not; the majority changes with the last view.
    const double turn = continuous ? 2.0 : std::numbers::pi / 2.0;
    const std::vector<double> turns = {0.0, turn, 0.0, turn, turn};
    for (int view = 0; view < 5; ++view) {
      const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
      const Eigen::Quaterniond seen =
          ExpSo3(0.3 * kDegree * error) * truth * ExpSo3(turns[static_cast<size_t>(view)] * axis);
      SeePart(seen, view, &estimator, &knowing);
      SeePart(seen, view, &estimator, &unknowing);
    }
    const ObjectEstimate estimate = knowing.Estimates().front();
    EXPECT_TRUE(estimate.converged) << continuous;
    EXPECT_LT(estimate.last_change, 1.0 * kDegree);
    EXPECT_LT(SymmetricAngle(symmetry, OrientationOf(estimate), truth), 0.5 * kDegree);
    EXPECT_FALSE(unknowing.Estimates().front().converged) << continuous;
  }
}

// As many views say one thing as another: what is likely decides. The tracker is told of it by a
// pose that the symmetry makes equal.
TEST(ObjectTracker, LikelyPosesDecideWhereViewsDoNot) {
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond one = ExpSo3(Eigen::Vector3d(0.7, -0.2, 0.1));
  const Eigen::Quaterniond other = ExpSo3(Eigen::Vector3d(-0.9, 0.8, 0.5));
  const std::vector<SymmetryGroup> groups = {
      SymmetryGroup::None(),
      SymmetryGroup::Cyclic(3, axis),
      SymmetryGroup::Dihedral(2, axis, Eigen::Vector3d::UnitX()),
      SymmetryGroup::Cyclic(1000, axis),
      SymmetryGroup::Continuous(axis, false),
      SymmetryGroup::Continuous(axis, true)};
  for (size_t i = 0; i < groups.size(); ++i) {
    const SymmetryGroup& symmetry = groups[i];
    Eigen::Quaterniond equal = ExpSo3(2.0 * axis);
    if (symmetry.kind == SymmetryGroup::Kind::kFinite) {
      equal = symmetry.elements[symmetry.elements.size() / 2];
    }
    if (symmetry.flips) equal = equal * ExpSo3(std::numbers::pi * Eigen::Vector3d::UnitY());
    for (const Eigen::Quaterniond& likely : {one, other}) {
      Estimator estimator;
      ObjectTracker tracker = TrackerOf(symmetry, {{likely * equal, 6.0 * kDegree, 1.0}});
      for (int view = 0; view < 6; ++view) {
        SeePart(view % 2 == 0 ? one : other, view, &estimator, &tracker);
      }
      const ObjectEstimate estimate = tracker.Estimates().front();
      EXPECT_LT(SymmetricAngle(symmetry, OrientationOf(estimate), likely), 0.1 * kDegree) << i;
    }
  }
}

// Of a continuous symmetry every turn is as likely.
TEST(ObjectTracker, ALikelyPoseStandsForAllItsEquivalentsAlike) {
  const SymmetryGroup symmetry = SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), true);
  const Eigen::Quaterniond likely = ExpSo3(Eigen::Vector3d(0.7, -0.2, 0.1));
  const double spread = 7.0 * kDegree;
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (int i = 0; i < 60; ++i) {
    Estimator estimator;
    ObjectTracker tracker = TrackerOf(symmetry, {{likely, spread, 1.0}}, 0.0);
    Eigen::Quaterniond q = likely * ExpSo3(Eigen::Vector3d(0.0, 0.0, 0.1047 * i));
    if (i % 2 == 1) q = q * ExpSo3(std::numbers::pi * Eigen::Vector3d::UnitX());
    SeePart(q, 0, &estimator, &tracker);
    const ObjectEstimate estimate = tracker.Estimates().front();
    const double density = estimate.histogram->Mass() / estimate.verification_weight;
    least = std::min(least, density);
    most = std::max(most, density);
  }
  EXPECT_GT(least, 5.0);
  EXPECT_LT(most, 1.15 * least);
}

TEST(ObjectTracker, WhatThePriorRulesOutIsNotReported) {
  const Eigen::Quaterniond seen = ExpSo3(Eigen::Vector3d(1.5, 0.0, 0.0));
  for (const double uniform_share : {0.0, 0.2}) {
    Estimator estimator;
    ObjectTracker tracker = TrackerOf(SymmetryGroup::None(),
                                      {{Eigen::Quaterniond::Identity(), 5.0 * kDegree, 1.0}},
                                      uniform_share);
    for (int view = 0; view < 5; ++view) SeePart(seen, view, &estimator, &tracker);
    EXPECT_EQ(tracker.Estimates().empty(), uniform_share == 0.0);
    EXPECT_EQ(tracker.state().instances.size(), 1U);
    // A copy, and what goes on from the saved state, know the same.
    ObjectTracker copy = tracker;
    ASSERT_TRUE(copy.Restore(tracker.state()).ok());
    SeePart(Eigen::Quaterniond::Identity(), 5, &estimator, &tracker);
    EXPECT_EQ(copy.Estimates().empty(), uniform_share == 0.0);
    EXPECT_FALSE(tracker.Estimates().empty());
  }
}

TEST(ObjectTracker, ParametersAreChecked) {
  EXPECT_FALSE((ObjectTrackerParameters{.prior_uniform_share = -0.1}).Validate().ok());
  EXPECT_FALSE((ObjectTrackerParameters{.prior_uniform_share = 1.1}).Validate().ok());
  EXPECT_TRUE(ObjectTrackerParameters().Validate().ok());
  EXPECT_FALSE((ObjectTrackerParameters{.gate = 0.0}).Validate().ok());
  EXPECT_FALSE((ObjectTrackerParameters{.confirm_views = 0}).Validate().ok());
  EXPECT_FALSE((ObjectTrackerParameters{.viewpoint = {.rotation = -1.0}}).Validate().ok());
}

// A tracker with a few objects and views in it.
ObjectTracker MakeUsedTracker(Estimator* estimator, int num_views) {
  Rng rng(9);
  ObjectTracker tracker = MakeTracker();
  for (int view = 0; view < num_views; ++view) {
    DetectionSet set = estimator->Set(Camera(35.0 * view));
    Estimator::Detect(&set, "mug", At(0.001 * rng.Normal(), 0.1, rng.Normal()), rng.Uniform());
    if (view % 2 == 0) Estimator::Detect(&set, "filter", At(-0.1, 0.0, 30.0 + rng.Normal()));
    tracker.Add(set);
  }
  return tracker;
}

TEST(TrackerState, GoesOnExactlyWhereItWas) {
  Estimator estimator;
  ObjectTracker tracker = MakeUsedTracker(&estimator, 5);
  const std::string text = FormatTrackerState(tracker.state());
  Result<TrackerState> parsed = ParseTrackerState(text);
  ASSERT_TRUE(parsed.ok()) << parsed.error().message;
  EXPECT_EQ(FormatTrackerState(*parsed), text);
  ObjectTracker restored = MakeTracker();
  ASSERT_TRUE(restored.Restore(*parsed).ok());

  DetectionSet next = estimator.Set(Camera(200.0));
  Estimator::Detect(&next, "mug", At(0.0, 0.1, 1.0));
  tracker.Add(next);
  restored.Add(next);
  EXPECT_FALSE(restored.Add(next).used);
  const std::vector<ObjectEstimate> a = tracker.Estimates();
  const std::vector<ObjectEstimate> b = restored.Estimates();
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].T_world_object.matrix(), b[i].T_world_object.matrix());
    EXPECT_EQ(a[i].center_covariance, b[i].center_covariance);
    EXPECT_EQ(a[i].last_change, b[i].last_change);
    EXPECT_EQ(a[i].entropy, b[i].entropy);
  }
}

TEST(TrackerState, CutTextIsRefused) {
  Estimator estimator;
  const std::string text = FormatTrackerState(MakeUsedTracker(&estimator, 3).state());
  for (size_t length = 0; length + 1 < text.size(); ++length) {
    ASSERT_FALSE(ParseTrackerState(text.substr(0, length)).ok()) << length;
  }
  EXPECT_FALSE(ParseTrackerState(text + "more").ok());
}

TEST(TrackerState, ChangedBytesNeverCrash) {
  Estimator estimator;
  const std::string text = FormatTrackerState(MakeUsedTracker(&estimator, 3).state());
  Rng rng(4);
  for (int i = 0; i < 3000; ++i) {
    std::string changed = text;
    changed[rng.Below(static_cast<uint32_t>(text.size()))] = static_cast<char>(rng.Below(256));
    const Result<TrackerState> parsed = ParseTrackerState(changed);
    if (!parsed) {
      EXPECT_FALSE(parsed.error().message.empty());
    }
  }
}

TEST(TrackerState, AnUnknownModelIsRefused) {
  Estimator estimator;
  const ObjectTracker tracker = MakeUsedTracker(&estimator, 2);
  ObjectTracker other(Grid(), {}, {{"bracket", {}}});
  const Result<void> restored = other.Restore(tracker.state());
  ASSERT_FALSE(restored.ok());
  EXPECT_NE(restored.error().message.find("mug"), std::string::npos);
}

TEST(TrackerState, ADetectionThatCountsNothingNowIsRefused) {
  Estimator estimator;
  const ObjectTracker tracker = MakeUsedTracker(&estimator, 2);
  ObjectTrackerParameters parameters;
  parameters.orientation.sigma_vw = 1e-8;  // The detections' MSE is 1e-6.
  const Result<void> restored =
      ObjectTracker(Grid(), parameters, Models()).Restore(tracker.state());
  ASSERT_FALSE(restored.ok());
  EXPECT_NE(restored.error().message.find("counts nothing"), std::string::npos);
}

}  // namespace
}  // namespace vantage
