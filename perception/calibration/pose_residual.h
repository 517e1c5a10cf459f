#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "perception/calibration/pose_adjustment.h"

namespace vantage {

/// ViewError() of one view, whitened, for automatic derivatives.
class PoseResidual {
 public:
  PoseResidual(HandEyeSetup setup, const AdjustmentView& view, const HandEyeCovariance& whitening)
      : setup_(setup),
        view_(view),
        q_base_hand_(view.T_base_hand.linear()),
        q_camera_target_(view.T_camera_target.linear()),
        whitening_(whitening) {}

  /// @param q_x, q_y (x, y, z, w). @param offset s.
  template <class T>
  bool operator()(const T* q_x,
                  const T* t_x,
                  const T* q_y,
                  const T* t_y,
                  const T* scale,
                  const T* offset,
                  T* residual) const {
    using Quaternion = Eigen::Quaternion<T>;
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Quaternion> Qx(q_x);
    const Eigen::Map<const Quaternion> Qy(q_y);
    const Vector turn = view_.angular_velocity.cast<T>() * offset[0];
    T wxyz[4];
    ceres::AngleAxisToQuaternion(turn.data(), wxyz);
    Quaternion q_a = Quaternion(wxyz[0], wxyz[1], wxyz[2], wxyz[3]) * q_base_hand_.cast<T>();
    Vector t_a =
        (view_.T_base_hand.translation().cast<T>() + view_.velocity.cast<T>() * offset[0]) *
        scale[0];
    if (setup_ == HandEyeSetup::kEyeToHand) {
      q_a = q_a.conjugate();
      t_a = -(q_a * t_a);
    }
    const Vector t_b = view_.T_camera_target.translation().cast<T>();
    const Vector t =
        q_a * (Qx * t_b + Eigen::Map<const Vector>(t_x)) + t_a - Eigen::Map<const Vector>(t_y);
    const Quaternion q = q_a * Qx * q_camera_target_.cast<T>() * Qy.conjugate();
    const T q_wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
    Eigen::Matrix<T, 6, 1> error;
    ceres::QuaternionToAngleAxis(q_wxyz, error.data());
    error.template tail<3>() = t;
    Eigen::Map<Eigen::Matrix<T, 6, 1>> whitened(residual);
    whitened = whitening_.cast<T>() * error;
    return true;
  }

 private:
  HandEyeSetup setup_;
  AdjustmentView view_;
  Eigen::Quaterniond q_base_hand_;
  Eigen::Quaterniond q_camera_target_;
  HandEyeCovariance whitening_;
};

}  // namespace vantage
