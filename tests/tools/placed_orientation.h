#pragma once

#include "common/rng.h"
#include "common/so3.h"

namespace vantage {

/// An orientation at a random place, 1 m from the origin.
inline Pose PlacedOrientation(const Eigen::Quaterniond& q, Rng& rng) {
  Pose pose = Pose::Identity();
  pose.linear() = q.toRotationMatrix();
  pose.translation() = rng.UnitVector();
  return pose;
}

}  // namespace vantage
