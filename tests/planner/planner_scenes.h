#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "common/check.h"
#include "common/triangle_mesh.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/mode_belief.h"
#include "planner/view_candidates.h"
#include "tests/fusion/confusion/synthetic_object.h"

namespace vantage {

/// Without smoothing, so that a direction's shares are its counts.
inline ConfusionModel MakeConfusion(const ContingencyTable& table,
                                    const SymmetryGroup& symmetry = SymmetryGroup::None(),
                                    double smoothing = 0.0) {
  ConfusionModelParameters parameters;
  parameters.direction_smoothing = smoothing;
  Result<ConfusionModel> model = ConfusionModel::Make(table, symmetry, parameters);
  VANTAGE_CHECK(model.ok(), "a synthetic table");
  return std::move(model).value();
}

/// Differences are turns about z by multiples of 360 / order degrees, in counts drawn anew for
/// each direction: whatever is added to a turn is a turn again.
inline ContingencyTable RandomTurns(int order, int num_directions, uint64_t seed) {
  SyntheticObject object;
  object.order = order;
  ContingencyTable table;
  table.key.num_directions = num_directions;
  Rng rng(seed);
  for (int i = 0; i < num_directions; ++i) {
    DirectionTrials& direction = table.directions.emplace_back();
    for (int turn = 0; turn < order; ++turn) {
      const auto count = static_cast<int>(rng.Below(60)) - 20;
      if (count > 0) SyntheticObject::Count(object.Turn(turn), &direction, count);
    }
    SyntheticObject::Count(object.Turn(0), &direction, 10);
    direction.missed = static_cast<int>(rng.Below(20));
    direction.trials += direction.missed;
  }
  return table;
}

/// Turns of `object` from q, with probabilities drawn at random, best first.
inline std::vector<OrientationHypothesis> RandomBelief(const SyntheticObject& object,
                                                       const Eigen::Quaterniond& q,
                                                       Rng& rng) {
  std::vector<OrientationHypothesis> belief;
  double sum = 0.0;
  for (int turn = 0; turn < object.order; ++turn) {
    belief.push_back({q * object.Turn(turn), rng.Uniform(0.05, 1.0)});
    sum += belief.back().probability;
  }
  for (OrientationHypothesis& one : belief) one.probability /= sum;
  std::sort(belief.begin(), belief.end(), [](const auto& a, const auto& b) {
    return a.probability > b.probability;
  });
  return belief;
}

/// A box around the origin. @param size m, its edges.
inline TriangleMesh BoxMesh(const Eigen::Vector3f& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner(
        (i & 1) != 0 ? 0.5F : -0.5F, (i & 2) != 0 ? 0.5F : -0.5F, (i & 4) != 0 ? 0.5F : -0.5F);
    mesh.vertices.emplace_back(corner.cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 1},
                    {1, 2, 3},
                    {4, 5, 6},
                    {5, 7, 6},
                    {0, 1, 4},
                    {1, 5, 4},
                    {2, 6, 3},
                    {3, 6, 7},
                    {0, 4, 2},
                    {2, 4, 6},
                    {1, 3, 5},
                    {3, 7, 5}};
  return mesh;
}

/// `count` views over the cap from 20 to 80 degrees, 0.75 m from the origin.
inline std::vector<Pose> ManyViews(int count) {
  ViewCandidateParameters parameters;
  parameters.lowest_elevation = 20.0 * kDegree;
  parameters.highest_elevation = 80.0 * kDegree;
  parameters.count = count;
  return MakeViewCandidates(parameters);
}

}  // namespace vantage
