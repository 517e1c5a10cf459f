#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "perception/calibration/reprojection.h"
#include "perception/calibration/reprojection_adjustment.h"

namespace vantage {

/// Reprojection errors of all points of a view, with analytic derivatives. Parameter blocks:
/// T_camera_target (quaternion x, y, z, w, then translation); fx, fy, cx, cy; k1, k2, p1, p2.
class PixelCost : public ceres::CostFunction {
 public:
  /// @param sigma px. @param k3 of the lens, which is not estimated.
  PixelCost(const ReprojectionView& view, double sigma, double k3)
      : view_(view), sigma_(sigma), k3_(k3) {
    set_num_residuals(2 * static_cast<int>(view.points.size()));
    *mutable_parameter_block_sizes() = {7, 4, 4};
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    using RowMajor4 = Eigen::Matrix<double, 2, 4, Eigen::RowMajor>;
    const Eigen::Map<const Eigen::Quaterniond> q(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> t(parameters[0] + 4);
    CameraModel camera;
    camera.fx = parameters[1][0];
    camera.fy = parameters[1][1];
    camera.cx = parameters[1][2];
    camera.cy = parameters[1][3];
    const LensDistortion distortion{.k1 = parameters[2][0],
                                    .k2 = parameters[2][1],
                                    .p1 = parameters[2][2],
                                    .p2 = parameters[2][3],
                                    .k3 = k3_};
    for (size_t i = 0; i < view_.points.size(); ++i) {
      const Eigen::Vector3d& p = view_.points[i].p_target;
      const Eigen::Vector3d cross = q.vec().cross(p);
      const Eigen::Vector3d p_camera = p + 2.0 * (q.w() * cross + q.vec().cross(cross)) + t;
      if (!(p_camera.z() > 1e-6)) return false;
      const Reprojection shown = Reproject(camera, distortion, p_camera);
      const double weight = std::sqrt(view_.weights[i]) / sigma_;
      Eigen::Map<Eigen::Vector2d>(residuals + 2 * i) =
          weight * (shown.pixel - view_.points[i].pixel);
      if (jacobians == nullptr) continue;
      if (jacobians[0] != nullptr) {
        // Of p + 2 w (v x p) + 2 v x (v x p) by v and w.
        Eigen::Matrix<double, 3, 4> by_q;
        by_q.leftCols<3>() = 2.0 * (q.vec().dot(p) * Eigen::Matrix3d::Identity() +
                                    q.vec() * p.transpose() - 2.0 * p * q.vec().transpose());
        by_q(0, 1) += 2.0 * q.w() * p.z();
        by_q(0, 2) -= 2.0 * q.w() * p.y();
        by_q(1, 0) -= 2.0 * q.w() * p.z();
        by_q(1, 2) += 2.0 * q.w() * p.x();
        by_q(2, 0) += 2.0 * q.w() * p.y();
        by_q(2, 1) -= 2.0 * q.w() * p.x();
        by_q.col(3) = 2.0 * cross;
        Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> by_pose(jacobians[0] + 14 * i);
        by_pose.leftCols<4>() = weight * shown.by_point * by_q;
        by_pose.rightCols<3>() = weight * shown.by_point;
      }
      if (jacobians[1] != nullptr) {
        Eigen::Map<RowMajor4>(jacobians[1] + 8 * i) = weight * shown.by_pinhole;
      }
      if (jacobians[2] != nullptr) {
        Eigen::Map<RowMajor4>(jacobians[2] + 8 * i) = weight * shown.by_distortion;
      }
    }
    return true;
  }

 private:
  const ReprojectionView& view_;
  double sigma_;
  double k3_;
};

/// How far the hand is from where X, Y and the target's pose in the camera say, in rotation or in
/// translation, for automatic derivatives.
class RobotCost {
 public:
  enum class Part { kRotation, kTranslation };

  RobotCost(Part part,
            const ReprojectionProblem& problem,
            const ReprojectionView& view,
            double sigma)
      : part_(part), problem_(problem), view_(view), sigma_(sigma) {}

  template <class T>
  bool operator()(const T* x,
                  const T* y,
                  const T* b,
                  const T* robot_scale,
                  const T* time_offset,
                  T* residual) const {
    using Quaternion = Eigen::Quaternion<T>;
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Quaternion> Qx(x);
    const Eigen::Map<const Quaternion> Qy(y);
    const Eigen::Map<const Quaternion> Qb(b);
    const Eigen::Map<const Vector> tx(x + 4);
    const Eigen::Map<const Vector> ty(y + 4);
    const Eigen::Map<const Vector> tb(b + 4);
    Quaternion told_q;
    Vector told_t;
    if (!Told(*time_offset, &told_q, &told_t)) return false;
    // T_base_hand = Y B^-1 X^-1 with the eye in the hand, its inverse otherwise.
    const bool in_hand = problem_.setup == HandEyeSetup::kEyeInHand;
    const Quaternion q = in_hand ? Quaternion(Qy * Qb.conjugate() * Qx.conjugate())
                                 : Quaternion(Qx * Qb * Qy.conjugate());
    Eigen::Map<Vector> error(residual);
    if (part_ == Part::kRotation) {
      const Quaternion difference = q * told_q.conjugate();
      const T wxyz[4] = {difference.w(), difference.x(), difference.y(), difference.z()};
      ceres::QuaternionToAngleAxis(wxyz, error.data());
    } else if (in_hand) {
      error = ty - q * tx - (Qy * Qb.conjugate()) * tb - *robot_scale * told_t;
    } else {
      error = Qx * tb + tx - q * ty - *robot_scale * told_t;
    }
    error *= T(1.0 / sigma_);
    return true;
  }

 private:
  /// The hand as the robot tells it, at the image's time and the offset. False where that is not
  /// known.
  template <class T>
  bool Told(const T& time_offset, Eigen::Quaternion<T>* q, Eigen::Matrix<T, 3, 1>* t) const {
    if (problem_.trajectory == nullptr) {
      *q = Eigen::Quaterniond(view_.T_base_hand.linear()).cast<T>();
      *t = view_.T_base_hand.translation().cast<T>();
      return true;
    }
    double offset = 0.0;
    if constexpr (std::is_same_v<T, double>) {
      offset = time_offset;
    } else {
      offset = time_offset.a;
    }
    constexpr double kStep = 1e3;  // us
    const double utime = static_cast<double>(view_.utime) + 1e6 * offset;
    const auto now = problem_.trajectory->At(utime);
    const auto before = problem_.trajectory->At(utime - kStep);
    const auto after = problem_.trajectory->At(utime + kStep);
    if (!now || !before || !after) return false;
    const double seconds = 2e-6 * kStep;
    const Eigen::Vector3d turn =
        LogSo3(Eigen::Quaterniond(after->linear() * before->linear().transpose())) / seconds;
    const Eigen::Vector3d velocity = (after->translation() - before->translation()) / seconds;
    // 0, with the derivative by the offset.
    const T later = time_offset - T(offset);
    const Eigen::Matrix<T, 3, 1> turned = turn.cast<T>() * later;
    T wxyz[4];
    ceres::AngleAxisToQuaternion(turned.data(), wxyz);
    *q = Eigen::Quaternion<T>(wxyz[0], wxyz[1], wxyz[2], wxyz[3]) *
         Eigen::Quaterniond(now->linear()).cast<T>();
    *t = now->translation().cast<T>() + velocity.cast<T>() * later;
    return true;
  }

  Part part_;
  const ReprojectionProblem& problem_;
  const ReprojectionView& view_;
  double sigma_;
};

}  // namespace vantage
