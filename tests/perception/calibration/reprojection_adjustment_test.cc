#include "perception/calibration/reprojection_adjustment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/calibration/reprojection.h"
#include "simulated_image_views.h"

namespace vantage {
namespace {

/// A problem that asks for everything, at a state off its solution.
struct Scene {
  explicit Scene(HandEyeSetup setup) {
    Rng rng(7);
    made =
        SimulateImageViews({.setup = setup, .target = {.columns = 2, .rows = 1}, .views = 2}, rng);
    std::vector<HandTrajectory::Sample> samples;
    for (size_t i = 0; i < made.views.size(); ++i) {
      // Each view in the middle of a motion of its own.
      ImageView& view = made.views[i];
      view.utime = 1'000'000 * static_cast<int64_t>(i + 1);
      const Eigen::Vector3d axis = rng.UnitVector();
      const Eigen::Vector3d step = 0.05 * rng.UnitVector();
      for (const double at : {-1.0, 1.0}) {
        Pose pose = view.T_base_hand;
        pose.linear() = pose.linear() * ExpSo3(0.1 * at * axis).toRotationMatrix();
        pose.translation() += at * step;
        samples.push_back({view.utime + static_cast<int64_t>(at * 90'000.0), pose});
      }
    }
    trajectory = HandTrajectory(samples);
    problem.setup = setup;
    problem.estimates_robot_scale = true;
    problem.estimates_pinhole = true;
    problem.estimates_distortion = true;
    problem.trajectory = &trajectory;
    problem.expected_camera = SimulatedImageRequest{}.camera;
    for (const ImageView& view : made.views) {
      std::vector<double> weights(view.points.size(), 1.0);
      weights[1] = 0.3;
      problem.views.push_back({view.points, weights, view.T_base_hand, view.utime});
    }
    state.transforms = {Disturbed(made.T_x, 0.01, 0.01, rng), Disturbed(made.T_y, 0.01, 0.01, rng)};
    state.robot_scale = 1.02;
    state.time_offset = 0.013;
    state.camera = problem.expected_camera;
    state.distortion = {.k1 = 0.1, .k2 = -0.2, .p1 = 0.01, .p2 = -0.02, .k3 = 0.05};
    for (const Pose& pose : made.T_camera_target) {
      state.T_camera_target.push_back(Disturbed(pose, 0.02, 0.005, rng));
    }
  }

  /// Half the squares of a view's parts where its pose and what is shared are moved.
  [[nodiscard]] Eigen::Vector3d Cost(size_t view, const Eigen::VectorXd& step) const {
    ReprojectionState moved = MovedShared(problem, state, step.tail(step.size() - 6));
    Pose& pose = moved.T_camera_target[view];
    pose.linear() = ExpSo3(step.segment<3>(0)) * pose.linear();
    pose.translation() += step.segment<3>(3);
    const ViewEquations equations = LinearizeReprojection(problem, moved)[view];
    return 0.5 * Eigen::Vector3d(equations.pixels.squared_error,
                                 equations.robot_rotation.squared_error,
                                 equations.robot_translation.squared_error);
  }

  SimulatedImageViews made;
  HandTrajectory trajectory;
  ReprojectionProblem problem;
  ReprojectionState state;
};

TEST(ReprojectionAdjustment, GradientsAreThoseOfTheCost) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    const Scene scene(setup);
    const std::vector<ViewEquations> equations = LinearizeReprojection(scene.problem, scene.state);
    constexpr Eigen::Index kSize = 6 + 12 + 1 + 1 + 4 + 4;
    for (size_t view = 0; view < equations.size(); ++view) {
      Eigen::Matrix<double, kSize, 3> gradient;
      gradient << equations[view].pixels.gradient, equations[view].robot_rotation.gradient,
          equations[view].robot_translation.gradient;
      for (Eigen::Index i = 0; i < kSize; ++i) {
        Eigen::VectorXd step = Eigen::VectorXd::Zero(kSize);
        step[i] = 1e-6;
        const Eigen::Vector3d slope =
            (scene.Cost(view, step) - scene.Cost(view, -step)) / (2.0 * step[i]);
        for (int part = 0; part < 3; ++part) {
          EXPECT_NEAR(slope[part], gradient(i, part), 1e-5 * (1.0 + std::abs(gradient(i, part))))
              << "parameter " << i << ", part " << part;
        }
      }
    }
  }
}

TEST(ReprojectionAdjustment, ErrorsAreThoseOfTheDefinition) {
  const Scene scene(HandEyeSetup::kEyeToHand);
  const std::vector<ViewEquations> equations = LinearizeReprojection(scene.problem, scene.state);
  for (size_t i = 0; i < equations.size(); ++i) {
    const ReprojectionState& state = scene.state;
    double pixels = 0.0;
    for (size_t k = 0; k < scene.problem.views[i].points.size(); ++k) {
      const TargetPoint& point = scene.problem.views[i].points[k];
      const Eigen::Vector3d p = state.T_camera_target[i] * point.p_target;
      const Eigen::Vector2d seen = state.distortion.Distort({p.x() / p.z(), p.y() / p.z()});
      const Eigen::Vector2d pixel(state.camera.fx * seen.x() + state.camera.cx,
                                  state.camera.fy * seen.y() + state.camera.cy);
      pixels += scene.problem.views[i].weights[k] * (pixel - point.pixel).squaredNorm();
    }
    EXPECT_NEAR(equations[i].pixels.squared_error, pixels, 1e-9 * pixels);
    const Pose hand =
        state.transforms.T_x * state.T_camera_target[i] * state.transforms.T_y.inverse();
    const Pose told =
        *scene.trajectory.At(static_cast<double>(scene.problem.views[i].utime) + 13'000.0);
    const double angle =
        GeodesicAngle(Eigen::Quaterniond(hand.linear()), Eigen::Quaterniond(told.linear()));
    EXPECT_NEAR(equations[i].robot_rotation.squared_error, angle * angle, 1e-9);
    const Eigen::Vector3d apart = hand.translation() - 1.02 * told.translation();
    EXPECT_NEAR(equations[i].robot_translation.squared_error, apart.squaredNorm(), 1e-9);
  }
}

TEST(ReprojectionAdjustment, FindsTheLeastSquares) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    Scene scene(setup);
    scene.problem.estimates_pinhole = false;
    scene.problem.estimates_distortion = false;
    scene.problem.estimates_robot_scale = false;
    scene.problem.trajectory = nullptr;
    scene.state.robot_scale = 1.0;
    scene.state.time_offset = 0.0;
    scene.state.distortion = {};
    const ReprojectionNoise noise{.pixel = 0.2, .robot_rotation = 3e-4, .robot_translation = 1e-4};
    ASSERT_TRUE(AdjustReprojection(scene.problem, noise, &scene.state));
    Eigen::VectorXd shared = Eigen::VectorXd::Zero(12);
    for (const ViewEquations& view : LinearizeReprojection(scene.problem, scene.state)) {
      const auto gradient = [&](Eigen::Index begin, Eigen::Index size) {
        return Eigen::VectorXd(view.pixels.gradient.segment(begin, size) / 0.04 +
                               view.robot_rotation.gradient.segment(begin, size) / 9e-8 +
                               view.robot_translation.gradient.segment(begin, size) / 1e-8);
      };
      EXPECT_LT(gradient(0, 6).norm(), 1.0);  // Of terms of 1e5 and more.
      shared += gradient(6, 12);
    }
    EXPECT_LT(shared.norm(), 1.0);
  }
}

}  // namespace
}  // namespace vantage
