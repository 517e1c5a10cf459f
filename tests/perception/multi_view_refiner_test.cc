#include "perception/refinement/multi_view_refiner.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>
#include <numbers>

#include "tests/perception/multi_view_test_scene.h"

namespace vantage {
namespace {

constexpr double kSigma = 0.001;  // m at 1 m

MultiViewScene OneObject(int views, double sigma, Rng& rng, const Pose& error = Pose::Identity()) {
  MultiViewScene scene(MakeAsymmetric());
  scene.Place(Pose(ExpSo3({0.0, 0.0, 0.4})));
  scene.LookAround(views, sigma, error, rng);
  return scene;
}

MultiViewRefined RefineOne(const RefinementStart& start,
                           std::span<const RefinementView> views,
                           const MultiViewParameters& parameters = WhiteNoise()) {
  return MultiViewRefiner(parameters).Refine({&start, 1}, views).objects.front();
}

TEST(MultiViewRefiner, FindsTheObjectInIdealDepth) {
  Rng rng(1);
  MultiViewScene scene = OneObject(6, 0.0, rng);
  const MultiViewRefined refined =
      RefineOne(scene.Start(0, 1.0 * kDegree, 0.002, rng), scene.views());
  ASSERT_TRUE(refined.is_refined) << refined.note;
  EXPECT_LT(scene.AngleOff(0, refined.T_world_object), 0.03 * kDegree);
  EXPECT_LT(scene.DistanceOff(0, refined.T_world_object), 0.0001);
  EXPECT_EQ(refined.views, 6);
  EXPECT_LT(refined.rms, 0.0002);
}

TEST(MultiViewRefiner, IsSureOfItselfAsFarAsItIsRight) {
  Rng rng(2);
  int covered = 0;
  constexpr int kTrials = 60;
  double sum = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    MultiViewScene scene = OneObject(3, 2.0 * kSigma, rng);
    MultiViewParameters parameters = WhiteNoise();
    parameters.single.bias_tilt = 0.0;  // None is simulated here.
    parameters.single.bias_at_1m = 0.0;
    parameters.camera_rotation = 0.0;
    parameters.camera_translation = 0.0;
    const MultiViewRefined refined =
        RefineOne(scene.Start(0, 0.3 * kDegree, 0.001, rng), scene.views(), parameters);
    ASSERT_TRUE(refined.is_refined) << refined.note;
    const Vector6 error = scene.Error(0, refined.T_world_object);
    const double squared = error.dot(refined.covariance.ldlt().solve(error));
    sum += squared;
    covered += squared < 12.592 ? 1 : 0;
  }
  EXPECT_GE(covered, 51);  // Of 57 that are expected, at 3 sigma.
  EXPECT_GT(sum / kTrials, 3.0);
  EXPECT_LT(sum / kTrials, 9.0);
}

TEST(MultiViewRefiner, DoesNotCareWhereTheWorldIs) {
  Rng rng(3);
  MultiViewScene scene = OneObject(4, kSigma, rng);
  RefinementStart start = scene.Start(0, 0.5 * kDegree, 0.001, rng);
  const MultiViewRefined here = RefineOne(start, scene.views());
  const Pose T_there_here = Pose(Eigen::Translation3d(1.0, -2.0, 0.5) * rng.Rotation());
  for (RefinementView& view : scene.views())
    view.T_world_camera = T_there_here * view.T_world_camera;
  start.T_world_object = T_there_here * start.T_world_object;
  const MultiViewRefined there = RefineOne(start, scene.views());
  ASSERT_TRUE(here.is_refined && there.is_refined);
  const Pose T = T_there_here * here.T_world_object;
  EXPECT_TRUE(there.T_world_object.isApprox(T, 1e-5));
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = T_there_here.linear();
  EXPECT_TRUE(there.covariance.isApprox(turn * here.covariance * turn.transpose(), 1e-2));
}

TEST(MultiViewRefiner, IsTheSameWhateverWasRefinedBefore) {
  Rng rng(4);
  MultiViewScene scene = OneObject(4, kSigma, rng);
  const RefinementStart start = scene.Start(0, 0.5 * kDegree, 0.001, rng);
  const RefinementStart other = scene.Start(0, 1.0 * kDegree, 0.002, rng);
  MultiViewRefiner refiner(WhiteNoise());
  const MultiViewRefined first = refiner.Refine({&start, 1}, scene.views()).objects.front();
  refiner.Refine({&other, 1}, scene.views());
  const MultiViewRefined again = refiner.Refine({&start, 1}, scene.views()).objects.front();
  EXPECT_EQ(first.T_world_object.matrix(), again.T_world_object.matrix());
  EXPECT_EQ(first.covariance, again.covariance);
}

TEST(MultiViewRefiner, BelievesCamerasAsFarAsItIsTold) {
  Rng rng(5);
  MultiViewScene scene = OneObject(6, 0.0, rng);
  const Pose error(Eigen::Translation3d(0.0, 0.0, 0.002));
  scene.views()[0].T_world_camera = scene.views()[0].T_world_camera * error;
  const RefinementStart start = scene.Start(0, 0.2 * kDegree, 0.0005, rng);
  MultiViewParameters parameters = WhiteNoise();
  parameters.camera_translation = 0.0;  // The robot makes no errors.
  parameters.camera_rotation = 0.0;
  const MultiViewResult fixed = MultiViewRefiner(parameters).Refine({&start, 1}, scene.views());
  EXPECT_TRUE(fixed.T_world_camera[0].isApprox(scene.views()[0].T_world_camera));
  parameters.camera_translation = 0.002;
  parameters.camera_rotation = 0.1 * kDegree;
  const MultiViewResult free = MultiViewRefiner(parameters).Refine({&start, 1}, scene.views());
  ASSERT_TRUE(free.objects[0].is_refined) << free.objects[0].note;
  const Pose truth = scene.views()[0].T_world_camera * error.inverse();
  EXPECT_LT((free.T_world_camera[0].translation() - truth.translation()).norm(), 0.0012);
  EXPECT_LT(scene.DistanceOff(0, free.objects[0].T_world_object), 0.001);
}

TEST(MultiViewRefiner, RecoversTheCamerasPoseInTheHand) {
  Rng rng(6);
  Pose error(Eigen::Translation3d(0.001, -0.002, 0.0015));
  error.linear() = ExpSo3(Eigen::Vector3d(0.3, -0.2, 0.25) * kDegree).toRotationMatrix();
  MultiViewScene scene(MakeAsymmetric());
  scene.Place(Pose(Eigen::Translation3d(-0.03, -0.02, 0.0)));
  scene.Place(Pose(Eigen::Translation3d(0.10, 0.05, 0.0) * ExpSo3({0.0, 0.0, 1.5})));
  // The robot tells poses that lack the error: true camera = told * error.
  scene.LookAround(8, 0.0, error, rng);
  const RefinementStart starts[] = {scene.Start(0, 0.4 * kDegree, 0.001, rng),
                                    scene.Start(1, 0.4 * kDegree, 0.001, rng)};
  MultiViewParameters parameters = WhiteNoise();
  parameters.adjust_hand_eye = true;
  parameters.rounds = 8;
  const MultiViewResult result = MultiViewRefiner(parameters).Refine(starts, scene.views());
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(result.objects[i].is_refined) << result.objects[i].note;
    EXPECT_LT(scene.AngleOff(i, result.objects[i].T_world_object), 0.08 * kDegree);
  }
  const Pose left = result.T_camera_adjusted.inverse() * error;
  EXPECT_LT(GeodesicAngle(Eigen::Quaterniond(left.linear()), Eigen::Quaterniond::Identity()),
            0.08 * kDegree);
  EXPECT_LT(left.translation().norm(), 0.0005);
}

TEST(MultiViewRefiner, RefusesWhatIsNotThere) {
  Rng rng(7);
  MultiViewScene scene = OneObject(5, kSigma, rng);
  RefinementStart start = scene.Start(0, 0.0, 0.0, rng);
  const Eigen::Vector3d center = start.T_world_object * scene.shape().center;
  // Half a turn about the vertical: as a box's other mode would be.
  start.T_world_object = Pose(Eigen::Translation3d(center) * ExpSo3({0.0, 0.0, std::numbers::pi}) *
                              Eigen::Translation3d(-center)) *
                         start.T_world_object;
  const MultiViewRefined turned = RefineOne(start, scene.views());
  EXPECT_FALSE(turned.is_refined);
  EXPECT_FALSE(turned.note.empty());
  EXPECT_EQ(turned.T_world_object.matrix(), start.T_world_object.matrix());
  const RefinementStart far = scene.Start(0, 6.0 * kDegree, 0.01, rng);
  EXPECT_FALSE(RefineOne(far, scene.views()).is_refined);
}

TEST(MultiViewRefiner, OneThatIsRefusedDoesNotHarmTheOther) {
  Rng rng(8);
  MultiViewScene scene = OneObject(5, kSigma, rng);
  const RefinementStart good = scene.Start(0, 0.5 * kDegree, 0.001, rng);
  RefinementStart bad = good;
  bad.T_world_object = Pose(Eigen::Translation3d(0.0, 0.0, 0.1)) * bad.T_world_object;
  const RefinementStart starts[] = {bad, good};
  const MultiViewResult both = MultiViewRefiner(WhiteNoise()).Refine(starts, scene.views());
  EXPECT_FALSE(both.objects[0].is_refined);
  ASSERT_TRUE(both.objects[1].is_refined) << both.objects[1].note;
  EXPECT_EQ(both.objects[1].T_world_object.matrix(),
            RefineOne(good, scene.views()).T_world_object.matrix());
}

TEST(MultiViewRefiner, IsSentencesForBadInput) {
  Rng rng(9);
  MultiViewScene scene = OneObject(3, kSigma, rng);
  const RefinementStart start = scene.Start(0, 0.2 * kDegree, 0.0, rng);
  const auto refused = [&](const RefinementStart& bad, std::span<const RefinementView> views) {
    const MultiViewRefined refined = RefineOne(bad, views);
    return !refined.is_refined && !refined.note.empty();
  };
  EXPECT_TRUE(refused(start, {}));
  const auto with = [&](const auto& change) {
    RefinementStart bad = start;
    change(&bad);
    return bad;
  };
  const auto spoil = [&](const auto& change) { return refused(with(change), scene.views()); };
  EXPECT_TRUE(spoil([](RefinementStart* bad) { bad->views = {}; }));
  EXPECT_TRUE(spoil([](RefinementStart* bad) { bad->views = {2, 1}; }));
  EXPECT_TRUE(spoil([](RefinementStart* bad) { bad->views = {1, 7}; }));
  EXPECT_TRUE(spoil([](RefinementStart* bad) {
    bad->T_world_object.translation().x() = std::numeric_limits<double>::quiet_NaN();
  }));
  EXPECT_TRUE(spoil([](RefinementStart* bad) { bad->T_world_object.linear() *= 2.0; }));
  EXPECT_TRUE(spoil([](RefinementStart* bad) { bad->max_rotation = -1.0; }));
  EXPECT_TRUE(MultiViewRefiner(WhiteNoise()).Refine({}, scene.views()).objects.empty());

  // Damaged views are as views that show nothing.
  std::vector<RefinementView> views = scene.views();
  const DepthImage empty(views[0].camera.width, views[0].camera.height);
  const DepthImage small(4, 4, 0.5F);
  const DepthImage infinite(
      views[0].camera.width, views[0].camera.height, std::numeric_limits<float>::infinity());
  for (const DepthImage* image :
       {&empty, &small, &infinite, static_cast<const DepthImage*>(nullptr)}) {
    views[0].depth = image;
    const MultiViewRefined refined = RefineOne(start, views);
    EXPECT_TRUE(refined.is_refined) << refined.note;
    EXPECT_EQ(refined.views, 2);
  }
  views[1].camera.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused(start, views));
}

TEST(MultiViewRefiner, CountsATurnThatNobodySeesAsOpen) {
  Rng rng(10);
  MultiViewScene scene = OneObject(4, kSigma, rng);
  RefinementStart start = scene.Start(0, 0.2 * kDegree, 0.0, rng);
  start.symmetry = SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), false);
  const MultiViewRefined refined = RefineOne(start, scene.views());
  ASSERT_TRUE(refined.is_refined) << refined.note;
  EXPECT_GT(refined.covariance(2, 2), 0.9);
  EXPECT_LT(refined.covariance(0, 0), 1e-4);
}

TEST(MultiViewParameters, NamesWhatIsOutOfRange) {
  EXPECT_TRUE(MultiViewParameters().Validate().ok());
  MultiViewParameters parameters;
  parameters.camera_rotation = -1.0;
  ASSERT_FALSE(parameters.Validate().ok());
  EXPECT_NE(parameters.Validate().error().message.find("camera_rotation = -1"), std::string::npos);
  parameters = {};
  parameters.rounds = 0;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.adjust_hand_eye = true;
  parameters.hand_eye_rotation = 0.0;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
