#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/bus.h"
#include "common/pose_buffer.h"
#include "nodes/extrinsics_config.h"
#include "perception/calibration/target_detector.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/camera_info_t.hpp"
#include "vantage/images_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {

/// A hand-eye calibration in which the robot moves itself: asks on NEXT_HAND_POSE for one pose
/// after another, first small turns in place, then those that would tell most; takes an image of
/// the target from each; ends when the 95 % ellipsoid is small enough. Publishes HANDEYE_RESULT
/// after every solution.
class LiveCalibration {
 public:
  /// Subscribes. `bus` outlives this. Errors: no [extrinsics.target], or no such target.
  static Result<std::unique_ptr<LiveCalibration>> Create(Bus& bus, const ExtrinsicsConfig& config);

  /// To be called at least ten times a second: repeats requests, and loses patience.
  void Poll();

  /// No more poses are asked for.
  [[nodiscard]] bool finished() const { return finished_; }
  /// The last solution; nothing before the first.
  [[nodiscard]] const std::optional<HandEyeResult>& result() const { return result_; }
  /// m and rad, the longest half axes of the 95 % ellipsoid.
  [[nodiscard]] double translation_bound() const;
  [[nodiscard]] double rotation_bound() const;
  /// us since the epoch, of the last image used.
  [[nodiscard]] int64_t last_utime() const { return last_utime_; }
  /// How it ended, in one sentence; while it runs, what is awaited.
  [[nodiscard]] const std::string& remark() const { return remark_; }

 private:
  LiveCalibration(Bus& bus,
                  const ExtrinsicsConfig& config,
                  std::unique_ptr<TargetDetector> detector);
  Result<void> Subscribe();
  void OnHand(const rigid_transform_t& message);
  void OnInfo(const camera_info_t& message);
  void OnImages(const images_t& message);
  void OnArmStatus(const arm_status_t& message);
  void ProcessPending();
  void TakeView(const images_t& message, const Pose& T_base_hand);
  void Solve();
  void GoOn();
  [[nodiscard]] std::optional<Pose> ChooseNext();
  [[nodiscard]] bool WasTried(const Pose& T_base_hand) const;
  [[nodiscard]] bool IsGoodEnough() const;
  void Ask(const Pose& T_base_hand);
  void PublishRequest();
  void Finish(const std::string& remark);

  Bus& bus_;
  ExtrinsicsConfig config_;
  std::unique_ptr<TargetDetector> detector_;
  std::vector<Eigen::Vector3d> target_points_;
  std::optional<CameraModel> camera_;
  PoseBuffer hands_;
  std::optional<images_t> pending_;  // Waits for hand poses of later times.

  std::optional<Pose> T_base_start_;
  std::vector<Pose> first_poses_;  // That are left, the last one next.
  std::optional<Pose> asked_;      // The pose that the hand goes to or is at.
  std::vector<Pose> tried_;
  int64_t asked_utime_ = 0;               // us
  int64_t repeated_utime_ = 0;            // us
  std::optional<int64_t> arrived_utime_;  // us
  int64_t request_seq_ = 0;
  std::string choice_;  // Why the pose was asked for.
  double gain_ = 0.0;

  std::vector<ImageView> views_;
  std::optional<HandEyeResult> result_;
  int64_t last_utime_ = 0;
  int64_t result_seq_ = 0;
  bool finished_ = false;
  std::string remark_ = "waiting for the hand's pose, the camera and the target in its image";
};

}  // namespace vantage
