#pragma once

#include <Eigen/Core>

#include "fusion/orientation_fusion.h"

namespace vantage {

/// The mean of all detections: "average orientation" of paper 7.3.1. The chordal mean, i.e. the
/// largest eigenvector of the sum of q q^T, which needs no choice between q and -q and minimizes
/// the squared Frobenius distance to the detections (Hartley et al., "Rotation Averaging", IJCV
/// 2013). All detections count the same. A view costs O(1) time and nothing is kept of it.
class MeanOrientation final : public OrientationFusion {
 public:
  Result<void> Add(const OrientationView& view) override;
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;

 private:
  Eigen::Matrix4d scatter_ = Eigen::Matrix4d::Zero();
};

}  // namespace vantage
