#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>

/// An arm that is none: it carries a camera straight to where it is sent, at 0.5 m/s. Put your
/// robot's own interface in its place. Poses are of the camera in the world: m; w, x, y, z.
class PretendArm {
 public:
  /// Starts to move. @return why it does not; empty when it does.
  std::string MoveTo(const double trans[3], const double quat[4]) {
    const double far = std::hypot(trans[0], trans[1], trans[2]);
    const double norm = std::hypot(std::hypot(quat[0], quat[1]), std::hypot(quat[2], quat[3]));
    if (!(std::abs(norm - 1.0) < 1e-3)) return "the orientation is no unit quaternion";
    if (!(far <= kReach && trans[2] >= kLowest)) return "the position is out of reach";
    double start[7];
    Pose(start, start + 3);
    double dot = 0.0;  // q and -q are the same: by the nearer one.
    for (int i = 0; i < 4; ++i) dot += start[3 + i] * quat[i];
    for (int i = 0; i < 7; ++i) {
      from_[i] = start[i];
      to_[i] = i < 3 ? trans[i] : (dot < 0.0 ? -quat[i - 3] : quat[i - 3]);
    }
    duration_ = 0.2 + std::hypot(to_[0] - from_[0], to_[1] - from_[1], to_[2] - from_[2]) / kSpeed;
    start_ = Clock::now();
    return "";
  }
  /// Where the camera is. @return when that was measured, us since the epoch
  int64_t Pose(double trans[3], double quat[4]) const {
    const double share = duration_ > 0.0 ? 1.0 - Remaining() / duration_ : 1.0;
    double pose[7];
    for (int i = 0; i < 7; ++i) pose[i] = from_[i] + share * (to_[i] - from_[i]);
    const double norm = std::hypot(std::hypot(pose[3], pose[4]), std::hypot(pose[5], pose[6]));
    for (int i = 0; i < 3; ++i) trans[i] = pose[i];
    for (int i = 0; i < 4; ++i) quat[i] = pose[3 + i] / norm;
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  }
  /// s until it arrives; 0 at rest.
  double Remaining() const {
    const std::chrono::duration<double> gone = Clock::now() - start_;
    return std::clamp(duration_ - gone.count(), 0.0, duration_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kSpeed = 0.5;   // m/s
  static constexpr double kReach = 1.5;   // m, from the world's origin
  static constexpr double kLowest = 0.1;  // m

  // At the start it looks down at the table from the front, as the simulated arm does.
  double from_[7] = {0.0, -0.53, 0.58, 0.38268343, -0.92387953, 0.0, 0.0};
  double to_[7] = {0.0, -0.53, 0.58, 0.38268343, -0.92387953, 0.0, 0.0};
  double duration_ = 0.0;  // s
  Clock::time_point start_ = Clock::now();
};
