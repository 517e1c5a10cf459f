#pragma once

#include <Eigen/Cholesky>
#include <array>

#include "common/simd.h"
#include "common/so3.h"

namespace vantage {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Normal equations of Gauss-Newton on a small motion of a body, a rotation vector about its center
/// and a translation: point-to-plane distances (Chen, Medioni 1992).
struct MotionEquations {
  Matrix6 information = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  double weight = 0.0;
  double weighted_square = 0.0;
  int pairs = 0;

  [[nodiscard]] double rms() const {
    return weight > 0.0 ? std::sqrt(weighted_square / weight) : 0.0;
  }
  /// The motion; directions that no measurement fixes stay where they are, by a weak prior.
  /// @param rotation, translation standard deviations of the prior, rad and m.
  [[nodiscard]] Vector6 Solve(double rotation, double translation) const {
    Matrix6 full = information;
    full.diagonal().head<3>().array() += 1.0 / (rotation * rotation);
    full.diagonal().tail<3>().array() += 1.0 / (translation * translation);
    return full.llt().solve(right);
  }
};

/// A transform, followed by a small motion about the image of nothing but `center` itself.
[[nodiscard]] Pose Moved(const Pose& T, const Vector6& motion, const Eigen::Vector3d& center);

/// The sums of MotionEquations in lanes, so that their order is fixed.
class MotionSums {
 public:
  /// Eight measurements: `distance` (m) off the surface along `normal`, at `arm` from the center.
  [[gnu::always_inline]] inline void Add(const F8s<3>& arm,
                                         const F8s<3>& normal,
                                         const F8& distance,
                                         const F8& weight);
  [[nodiscard]] MotionEquations Reduced() const;

 private:
  F8s<21> information_{};  // Upper triangle, row by row.
  F8s<6> right_{};
  F8 weight_{};
  F8 weighted_square_{};
  I8 pairs_{};
};

void MotionSums::Add(const F8s<3>& arm,
                     const F8s<3>& normal,
                     const F8& distance,
                     const F8& weight) {
  const F8s<6> jacobian = {arm[1] * normal[2] - arm[2] * normal[1],
                           arm[2] * normal[0] - arm[0] * normal[2],
                           arm[0] * normal[1] - arm[1] * normal[0],
                           normal[0],
                           normal[1],
                           normal[2]};
  size_t k = 0;
  for (size_t i = 0; i < 6; ++i) {
    const F8 weighted = weight * jacobian[i];
    for (size_t j = i; j < 6; ++j) information_[k++] += weighted * jacobian[j];
    right_[i] += weighted * distance;
  }
  weight_ += weight;
  weighted_square_ += weight * distance * distance;
  pairs_ -= weight > 0.0F;  // A true lane is -1.
}

}  // namespace vantage
