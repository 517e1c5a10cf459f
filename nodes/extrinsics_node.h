#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/bus.h"
#include "bus/gray_conversion.h"
#include "common/detection.h"
#include "common/pose_buffer.h"
#include "nodes/config_reader.h"
#include "nodes/extrinsics_config.h"
#include "nodes/handeye_file.h"
#include "nodes/node.h"
#include "nodes/process.h"
#include "perception/calibration/drift_check.h"
#include "perception/calibration/target_detector.h"
#include "vantage/camera_info_t.hpp"
#include "vantage/detections_v2_t.hpp"
#include "vantage/images_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {

/// vantage-extrinsics: turns the robot's hand poses into CAMERA_<NAME>_TO_WORLD by a hand-eye
/// calibration (a camera that stands still: 10 Hz), and NEXT_VIEW into NEXT_HAND_POSE; publishes
/// HANDEYE_RESULT at 1 Hz; compares the target or objects that are seen from a resting hand with
/// what the calibration says, on HANDEYE_CHECK at 1 Hz and in PROCESS_STATUS.
class ExtrinsicsNode : public Node {
 public:
  /// Subscribes. `bus` outlives the node. Errors: the calibration is another camera's or set-up's;
  /// the target.
  static Result<std::unique_ptr<ExtrinsicsNode>> Create(Bus& bus,
                                                        const ExtrinsicsConfig& config,
                                                        const HandEyeFile& calibration);

  void Poll() override { Tick(); }

 private:
  ExtrinsicsNode(Bus& bus, const ExtrinsicsConfig& config, const HandEyeFile& calibration);
  Result<void> Subscribe();
  void OnHand(const rigid_transform_t& message);
  void OnInfo(const camera_info_t& message);
  void OnImages(const images_t& message);
  void OnDetections(const std::string& channel, const detections_v2_t& message);
  void OnNextView(const next_view_t& message);
  void ProcessPending();
  void LookForTarget(const GrayFrame& frame, const Pose& T_base_hand);
  void AddDetection(const Detection& detection, const Pose& T_base_hand);
  [[nodiscard]] std::optional<Pose> HandAtRest(int64_t utime) const;
  void Tick();
  void PublishCamera(const Pose& T_world_camera, int64_t utime);
  void PublishCheck();
  void Report(const std::string& problem);

  static constexpr size_t kMaxPending = 4;  // What waits for hand poses of later times.

  /// An object that lies still.
  struct Thing {
    std::string model_id;
    Eigen::Vector3d p_base;  // m
    int reference;
  };

  Bus& bus_;
  ExtrinsicsConfig config_;
  HandEyeFile calibration_;
  std::string channel_;  // Of the camera.
  std::unique_ptr<TargetDetector> detector_;
  std::optional<CameraModel> camera_;
  LensDistortion distortion_;
  PoseBuffer hands_;  // By the image's time.
  std::deque<GrayFrame> pending_;
  std::deque<DetectionSet> pending_detections_;
  std::vector<Thing> things_;
  DriftCheck check_;
  std::optional<DriftReport> report_;
  int64_t checked_utime_ = 0;  // Of the last image used.
  bool saw_target_ = false;
  std::optional<int64_t> looked_utime_, camera_utime_, result_utime_, check_utime_;
  int64_t result_seq_ = 0;
  int64_t check_seq_ = 0;
  std::string problem_;
  std::string state_ = "ok";
};

/// For RunProcess and vantage-replay: reads [extrinsics] and the calibration that it names.
Result<std::unique_ptr<Node>> MakeExtrinsicsNode(Bus& bus,
                                                 ConfigReader& config,
                                                 const ProcessOptions& options);

}  // namespace vantage
