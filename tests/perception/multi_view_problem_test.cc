#include "perception/refinement/multi_view_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "common/rng.h"
#include "perception/refinement/view_evidence.h"
#include "tests/perception/multi_view_test_scene.h"

namespace vantage {
namespace {

Matrix6 RandomInformation(Rng& rng) {
  Matrix6 root;
  for (int i = 0; i < 36; ++i) root(i) = rng.Normal();
  return 1e4 * root * root.transpose();
}

Vector6 RandomVector(double scale, Rng& rng) {
  Vector6 vector;
  for (double& value : vector) value = scale * rng.Normal();
  return vector;
}

// Two objects in three views, terms that agree with no state.
struct Toy {
  std::vector<Pose> cameras;
  MultiViewProblem problem;
  MultiViewState state;

  explicit Toy(Rng& rng) {
    for (int i = 0; i < 3; ++i) {
      cameras.push_back(LookAt(0.7 * rng.UnitVector(), Eigen::Vector3d::Zero()));
    }
    problem.T_world_camera = cameras;
    problem.camera_rotation = 0.01;
    problem.camera_translation = 0.003;
    problem.bias_tilt = 0.001;
    problem.bias_at_1m = 0.0003;
    for (int i = 0; i < 2; ++i) {
      problem.centers.push_back(0.05 * rng.UnitVector());
      Pose T(rng.Rotation());
      T.translation() = 0.1 * rng.UnitVector();
      problem.T_world_object_start.push_back(T);
      state.T_world_object.push_back(T);
    }
    state.camera.assign(3, Vector6::Zero());
    for (size_t object = 0; object < 2; ++object) {
      for (size_t view = 0; view < 3; ++view) {
        ViewTerm term{object, view, cameras[view].inverse() * state.T_world_object[object]};
        term.information = RandomInformation(rng);
        term.right = term.information * RandomVector(0.002, rng);
        problem.terms.push_back(term);
      }
    }
  }
};

Pose MovedObject(const Pose& T, const Eigen::Vector3d& center, const Vector6& motion) {
  return Moved(T, motion, T * center);
}

TEST(MultiViewProblem, GradientIsThatOfDifferences) {
  Rng rng(1);
  Toy toy(rng);
  for (Vector6& camera : toy.state.camera) camera = RandomVector(0.002, rng);
  std::vector<Vector6> by_objects;
  std::vector<Vector6> by_cameras;
  MultiViewCost(toy.problem, toy.state, &by_objects, &by_cameras);
  ASSERT_EQ(by_objects.size(), 2U);
  ASSERT_EQ(by_cameras.size(), 3U);
  constexpr double kStep = 1e-6;
  std::vector<Vector6> unused;
  const auto cost = [&](const MultiViewState& state) {
    return MultiViewCost(toy.problem, state, &unused, &unused);
  };
  for (int k = 0; k < 6; ++k) {
    const Vector6 step = kStep * Vector6::Unit(k);
    for (size_t i = 0; i < 2; ++i) {
      MultiViewState up = toy.state;
      MultiViewState down = toy.state;
      up.T_world_object[i] = MovedObject(up.T_world_object[i], toy.problem.centers[i], step);
      down.T_world_object[i] = MovedObject(down.T_world_object[i], toy.problem.centers[i], -step);
      const double slope = (cost(up) - cost(down)) / (2.0 * kStep);
      EXPECT_NEAR(by_objects[i][k], slope, 1e-4 * by_objects[i].norm());
    }
    for (size_t i = 0; i < 3; ++i) {
      MultiViewState up = toy.state;
      MultiViewState down = toy.state;
      up.camera[i] += step;
      down.camera[i] -= step;
      const double slope = (cost(up) - cost(down)) / (2.0 * kStep);
      EXPECT_NEAR(by_cameras[i][k], slope, 1e-4 * by_cameras[i].norm());
    }
  }
}

TEST(MultiViewProblem, SolutionHasNoGradient) {
  Rng rng(2);
  Toy toy(rng);
  std::vector<Vector6> before, after, cameras;
  const double start = MultiViewCost(toy.problem, toy.state, &before, &cameras);
  std::vector<Matrix6> covariances;
  ASSERT_TRUE(SolveMultiView(toy.problem, &toy.state, &covariances));
  EXPECT_LT(MultiViewCost(toy.problem, toy.state, &after, &cameras), start);
  for (size_t i = 0; i < 2; ++i) EXPECT_LT(after[i].norm(), 1e-4 * before[i].norm());
  ASSERT_EQ(covariances.size(), 2U);
  for (const Matrix6& covariance : covariances) {
    EXPECT_EQ(covariance, Matrix6(covariance.transpose()));
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(covariance).eigenvalues()[0], 0.0);
  }
}

// With cameras that are known the covariance is the inverse of all views' information.
TEST(MultiViewProblem, CovarianceIsThatOfTheSumOfInformation) {
  Rng rng(3);
  Toy toy(rng);
  toy.problem.camera_rotation = toy.problem.camera_translation = 0.0;
  toy.problem.bias_tilt = toy.problem.bias_at_1m = 0.0;
  for (ViewTerm& term : toy.problem.terms) term.right.setZero();
  std::vector<Matrix6> covariances;
  ASSERT_TRUE(SolveMultiView(toy.problem, &toy.state, &covariances));
  for (size_t object = 0; object < 2; ++object) {
    Matrix6 sum = Matrix6::Zero();
    for (const ViewTerm& term : toy.problem.terms) {
      if (term.object != object) continue;
      Matrix6 turn = Matrix6::Zero();
      turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = toy.cameras[term.view].linear();
      sum += turn * term.information * turn.transpose();
    }
    EXPECT_TRUE(covariances[object].isApprox(Matrix6(sum.inverse()), 1e-2));
  }
}

// The equations of a view against sums over its pixels, one by one.
TEST(ViewEvidence, IsThatOfAllPixelsOneByOne) {
  Rng rng(4);
  MultiViewScene scene(MakeAsymmetric());
  scene.Place(Pose::Identity());
  scene.LookAround(1, 0.001, Pose::Identity(), rng);
  const RefinementView& view = scene.views()[0];
  const RefinementStart start = scene.Start(0, 0.3 * kDegree, 0.0005, rng);
  const Pose T = view.T_world_camera.inverse() * start.T_world_object;
  MultiViewParameters parameters = WhiteNoise();
  parameters.single.model_error = 0.0;
  const ViewEvidence evidence = ViewEvidenceGatherer().Gather(
      scene.shape(), T, view.camera, *view.depth, 1000000, Weighing::kAlike, 1.0, parameters);
  ModelView drawn;
  drawn.Render(scene.shape().mesh, T, view.camera, WholeImage(view.camera), 1);
  const Eigen::Vector3d center = T * scene.shape().center;
  Matrix6 information = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  std::map<std::pair<int, int>, float> inverse;
  drawn.ForEachPixel([&](const ModelView::Pixel& pixel) {
    inverse[{pixel.u, pixel.v}] = 1.0F / pixel.depth;
  });
  const auto is_step = [&](const ModelView::Pixel& pixel) {
    for (const auto& [du, dv] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const auto next = inverse.find({pixel.u + du, pixel.v + dv});
      if (next == inverse.end()) return true;
      if (std::abs(next->second - 1.0F / pixel.depth) > 0.02F) return true;
    }
    return false;
  };
  drawn.ForEachPixel([&](const ModelView::Pixel& pixel) {
    if (is_step(pixel)) return;
    const Eigen::Vector3d ray = view.camera.Unproject(pixel.u, pixel.v, 1.0);
    const Eigen::Vector3d normal =
        VisibleNormal(
            scene.shape().mesh, T.linear().cast<float>(), pixel.triangle, ray.cast<float>())
            .cast<double>();
    const double cosine = -normal.dot(ray) / ray.norm();
    if (cosine * cosine < 0.06) return;
    const double depth = static_cast<double>(pixel.depth);
    const double angle = std::acos(cosine);
    const double left = 0.5 * std::numbers::pi - angle;
    const double slanted =
        cosine < 0.5 ? 1e-4 / std::sqrt(depth) * angle * angle / (left * left) : 0.0;
    const double sigma = std::hypot(parameters.single.noise.Axial(depth), slanted);
    const double slope = 1.0 / (normal.dot(ray) * sigma);
    Vector6 row;
    row << slope * (depth * ray - center).cross(normal), slope * normal;
    const double residual = (static_cast<double>(view.depth->at(pixel.u, pixel.v)) - depth) / sigma;
    const double rest = 1.0 - residual * residual / 16.0;  // Of Tukey's biweight at 4 sigma.
    if (!(rest > 0.0)) return;
    information += rest * rest * row * row.transpose();
    right += rest * rest * residual * row;
  });
  EXPECT_LT((evidence.information - information).norm(), 0.03 * information.norm());
  const Vector6 motion = evidence.information.ldlt().solve(evidence.right);
  const Vector6 expected = information.ldlt().solve(right);
  EXPECT_LT((motion - expected).norm(), 0.05 * expected.norm());
}

TEST(ViewEvidence, WhitenedTellsTheSameMotionOfIdealDepth) {
  Rng rng(5);
  MultiViewScene scene(MakeAsymmetric());
  scene.Place(Pose::Identity());
  scene.LookAround(1, 0.0, Pose::Identity(), rng);
  const RefinementView& view = scene.views()[0];
  const RefinementStart start = scene.Start(0, 0.1 * kDegree, 0.0002, rng);
  const Pose T = view.T_world_camera.inverse() * start.T_world_object;
  ViewEvidenceGatherer gatherer;
  const MultiViewParameters parameters;
  for (const Weighing weighing : {Weighing::kAlike, Weighing::kWhitened}) {
    const ViewEvidence evidence = gatherer.Gather(
        scene.shape(), T, view.camera, *view.depth, 1000000, weighing, 1.0, parameters);
    EXPECT_GT(evidence.pixels, 1000);
    EXPECT_EQ(evidence.information, Matrix6(evidence.information.transpose()));
    const Pose moved =
        Moved(T, evidence.information.ldlt().solve(evidence.right), T * scene.shape().center);
    EXPECT_LT(scene.AngleOff(0, view.T_world_camera * moved), 0.03 * kDegree);
  }
}

TEST(ViewEvidence, NothingIsToldByNoDepth) {
  Rng rng(6);
  MultiViewScene scene(MakeAsymmetric());
  scene.Place(Pose::Identity());
  scene.LookAround(1, 0.0, Pose::Identity(), rng);
  const RefinementView& view = scene.views()[0];
  const DepthImage empty(view.camera.width, view.camera.height);
  const Pose T = view.T_world_camera.inverse();
  for (const Weighing weighing : {Weighing::kAlike, Weighing::kWhitened}) {
    const ViewEvidence evidence = ViewEvidenceGatherer().Gather(
        scene.shape(), T, view.camera, empty, 5000, weighing, 1.0, MultiViewParameters());
    EXPECT_EQ(evidence.pixels, 0);
    EXPECT_EQ(evidence.information, Matrix6(Matrix6::Zero()));
  }
  const Pose behind = Pose(Eigen::Translation3d(0.0, 0.0, -1.0));
  EXPECT_EQ(ViewEvidenceGatherer()
                .Gather(scene.shape(),
                        behind,
                        view.camera,
                        *view.depth,
                        5000,
                        Weighing::kAlike,
                        1.0,
                        MultiViewParameters())
                .compared,
            0);
}

}  // namespace
}  // namespace vantage
