#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/confusion/viewing_direction.h"

namespace vantage {

/// An object that looks the same after each turn by 2 pi / order about z but for a feature on its
/// +x side, and an estimator that guesses evenly which turn it is where it can't see the feature.
struct SyntheticObject {
  int order = 4;
  double visible_share = 0.4;    ///< of all directions, those from which the feature is seen
  double error = 0.5 * kDegree;  ///< rad, of detections in each of three axes
  double outliers = 0.0;         ///< share of detections that are anywhere
  double missed = 0.0;           ///< share of looks that find nothing

  [[nodiscard]] bool IsVisible(const Eigen::Vector3d& direction) const {
    return direction.x() >= 1.0 - 2.0 * visible_share;
  }
  [[nodiscard]] Eigen::Quaterniond Turn(int i) const {
    return ExpSo3(2.0 * std::numbers::pi * i / order * Eigen::Vector3d::UnitZ());
  }
  /// Share of a turn in the detections that are no outliers.
  [[nodiscard]] double Share(const Eigen::Vector3d& direction, int turn) const {
    if (IsVisible(direction)) return turn == 0 ? 1.0 : 0.0;
    return 1.0 / order;
  }
  /// What is detected of an object in this orientation, in the same frame.
  std::optional<Eigen::Quaterniond> Detect(const Eigen::Quaterniond& q_camera_object,
                                           Rng& rng) const {
    if (rng.Uniform() < missed) return std::nullopt;
    if (rng.Uniform() < outliers) return rng.Rotation();
    const bool visible = IsVisible(ViewingDirection(q_camera_object));
    const auto turn = visible ? 0U : rng.Below(static_cast<uint32_t>(order));
    const Eigen::Vector3d noise(rng.Normal(), rng.Normal(), rng.Normal());
    return q_camera_object * Turn(static_cast<int>(turn)) * ExpSo3(error * noise);
  }

  /// Adds a difference rotation to those of a direction.
  static void Count(const Eigen::Quaterniond& difference, DirectionTrials* direction, int count) {
    const std::array<int16_t, 3> steps = DifferenceCount::StepsOf(difference);
    const auto found =
        std::ranges::lower_bound(direction->differences, steps, {}, &DifferenceCount::steps);
    if (found != direction->differences.end() && found->steps == steps) {
      found->count += count;
    } else {
      direction->differences.insert(found, {steps, count});
    }
    direction->trials += count;
  }

  [[nodiscard]] ContingencyTable Measure(int num_directions, int trials, uint64_t seed) const {
    ContingencyTable table;
    table.key.model_id = "synthetic";
    table.key.num_directions = num_directions;
    const DirectionGrid grid(num_directions);
    Rng rng(seed);
    for (int i = 0; i < num_directions; ++i) {
      DirectionTrials& direction = table.directions.emplace_back();
      for (int trial = 0; trial < trials; ++trial) {
        const Eigen::Quaterniond truth =
            OrientationSeenFrom(grid.Sample(i, rng), rng.Uniform(0.0, 2.0 * std::numbers::pi));
        const std::optional<Eigen::Quaterniond> detected = Detect(truth, rng);
        if (detected) {
          Count(truth.conjugate() * *detected, &direction, 1);
        } else {
          ++direction.trials;
          ++direction.missed;
        }
      }
    }
    return table;
  }
};

}  // namespace vantage
