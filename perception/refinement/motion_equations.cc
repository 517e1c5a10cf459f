#include "perception/refinement/motion_equations.h"

namespace vantage {
namespace {

double Total(const F8& lanes) {
  double total = 0.0;
  for (int i = 0; i < kLanes; ++i) total += static_cast<double>(lanes[i]);
  return total;
}

}  // namespace

Pose Moved(const Pose& T, const Vector6& motion, const Eigen::Vector3d& center) {
  const Eigen::Quaterniond turn = ExpSo3(motion.head<3>());
  Pose moved;
  moved.linear() = (turn * Eigen::Quaterniond(T.linear())).normalized().toRotationMatrix();
  moved.translation() = turn * (T.translation() - center) + center + motion.tail<3>();
  return moved;
}

MotionEquations MotionSums::Reduced() const {
  MotionEquations equations;
  size_t k = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      equations.information(i, j) = equations.information(j, i) = Total(information_[k++]);
    }
    equations.right[i] = Total(right_[static_cast<size_t>(i)]);
  }
  equations.weight = Total(weight_);
  equations.weighted_square = Total(weighted_square_);
  for (int i = 0; i < kLanes; ++i) equations.pairs += pairs_[i];
  return equations;
}

}  // namespace vantage
