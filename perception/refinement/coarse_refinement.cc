#include "perception/refinement/coarse_refinement.h"

#include <algorithm>
#include <cmath>

#include "perception/refinement/motion_equations.h"

namespace vantage {
namespace {

constexpr float kLikeNormals = 0.7F;  // Cosine of 45 deg.
constexpr int kFewestPairs = 12;

// A pose in floats, row by row.
struct Placement {
  std::array<float, 9> rotation;
  std::array<float, 3> translation;

  explicit Placement(const Pose& T) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        rotation[static_cast<size_t>(3 * i + j)] = static_cast<float>(T.linear()(i, j));
      }
      translation[static_cast<size_t>(i)] = static_cast<float>(T.translation()[i]);
    }
  }
  [[gnu::always_inline]] void Turn(const F8s<3>& from, F8s<3>* to) const {
    for (size_t i = 0; i < 3; ++i) {
      (*to)[i] =
          rotation[3 * i] * from[0] + rotation[3 * i + 1] * from[1] + rotation[3 * i + 2] * from[2];
    }
  }
  [[gnu::always_inline]] void Move(const F8s<3>& from, F8s<3>* to) const {
    Turn(from, to);
    for (size_t i = 0; i < 3; ++i) (*to)[i] += translation[i];
  }
};

[[gnu::always_inline]] inline void Dot(const F8s<3>& a, const F8s<3>& b, F8* product) {
  *product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Scene points brought to the model, and the model points nearest to them.
struct Match {
  F8s<3> place, normal;          // m, of the scene's
  F8s<3> offset, target_normal;  // m, to the model's; its normal
  F8 likeness;                   // Cosine between the normals.

  [[gnu::always_inline]] Match(const NearestGrid& grid,
                               const Placement& T_object_camera,
                               const ScenePoints::Block& block) {
    T_object_camera.Move(block.position, &place);
    T_object_camera.Turn(block.normal, &normal);
    grid.FindLanes(place, &offset, &target_normal);
    for (size_t i = 0; i < 3; ++i) offset[i] -= place[i];
    Dot(normal, target_normal, &likeness);
  }
};

struct Cuts {
  float distance_squared;  // m^2, beyond which pairs count for nothing
  float variance;          // m^2, of the pairing, which adds to that of the sensor
};

VANTAGE_SIMD void Accumulate(const NearestGrid& grid,
                             const Placement& T_object_camera,
                             const std::array<float, 3>& center,
                             std::span<const ScenePoints::Block> blocks,
                             const Cuts& cuts,
                             MotionSums* sums) {
  const float inverse_cut = 1.0F / cuts.distance_squared;
  for (const ScenePoints::Block& block : blocks) {
    const Match match(grid, T_object_camera, block);
    F8 squared;
    F8 distance;
    Dot(match.offset, match.offset, &squared);
    Dot(match.offset, match.target_normal, &distance);
    const F8 rest = 1.0F - squared * inverse_cut;  // Of Tukey's biweight.
    const F8 weight = rest * rest / (block.variance + cuts.variance);
    F8s<3> arm;
    for (size_t i = 0; i < 3; ++i) arm[i] = match.place[i] - center[i];
    const auto is_pair = (match.likeness > kLikeNormals) & (rest > 0.0F);
    sums->Add(arm, match.target_normal, distance, is_pair ? weight : F8{});
  }
}

// Between the parameters' reaches in geometric progression, of the diameter.
double Reach(const RefinementParameters& parameters, int iteration) {
  if (parameters.coarse_iterations < 2) return parameters.coarse_reach_end;
  return parameters.coarse_reach *
         std::pow(parameters.coarse_reach_end / parameters.coarse_reach,
                  static_cast<double>(iteration) / (parameters.coarse_iterations - 1));
}

}  // namespace

CoarselyRefined RefineCoarse(const NearestGrid& grid,
                             const ModelShape& model,
                             const Pose& T_camera_object,
                             const ScenePoints& points,
                             const RefinementParameters& parameters) {
  constexpr double kPriorRotation = 0.2;     // rad
  constexpr double kPriorTranslation = 0.1;  // Of the diameter.
  constexpr double kPairing = 0.005;         // Of the diameter, standard deviation.
  constexpr double kSettled = 2e-3;          // rad, and of the diameter
  const Eigen::Vector3f center = model.center.cast<float>();
  CoarselyRefined refined;
  Pose T_object_camera = T_camera_object.inverse();
  for (int i = 0; i < parameters.coarse_iterations; ++i) {
    const double cut = model.diameter * Reach(parameters, i);
    const double pairing = kPairing * model.diameter;
    MotionSums sums;
    Accumulate(grid,
               Placement(T_object_camera),
               {center.x(), center.y(), center.z()},
               points.blocks(),
               {static_cast<float>(cut * cut), static_cast<float>(pairing * pairing)},
               &sums);
    const MotionEquations equations = sums.Reduced();
    refined.pairs = equations.pairs;
    refined.rms = equations.rms();
    if (equations.pairs < kFewestPairs) break;
    const Vector6 motion = equations.Solve(kPriorRotation, kPriorTranslation * model.diameter);
    T_object_camera = Moved(T_object_camera, motion, model.center);
    if (motion.head<3>().norm() + motion.tail<3>().norm() / model.diameter < kSettled) break;
  }
  refined.T_camera_object = T_object_camera.inverse();
  return refined;
}

}  // namespace vantage
