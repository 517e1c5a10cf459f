#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bus/bus.h"
#include "bus/image_conversion.h"
#include "bus/sequence_tracker.h"
#include "common/pose_buffer.h"
#include "nodes/config_reader.h"
#include "nodes/estimator_config.h"
#include "nodes/node.h"
#include "nodes/process.h"
#include "perception/estimator/pose_estimator.h"
#include "vantage/camera_info_t.hpp"
#include "vantage/images_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {

/// Finds poses in an image, with random numbers that depend on the image's utime alone. What it
/// returns is valid until the next call. @param times may be null.
using EstimateFunction = std::function<const PoseEstimator::Output&(
    const DepthFrame& frame, const CameraModel& camera, StageTimes* times)>;

/// Estimates by `estimator`, each image with a stream of its own of the numbers of `seed`.
EstimateFunction EstimateBy(std::shared_ptr<PoseEstimator> estimator, uint64_t seed);

/// DETECTIONS_<NAME>, of the process's name in capitals.
std::string DetectionsChannel(const std::string& process_name);

/// vantage-ppf and vantage-shot: detections_v2_t on DETECTIONS_<NAME> for every image of its camera
/// taken at rest, also when nothing was found in it. NAME is the process's in capitals.
class EstimatorNode : public Node {
 public:
  /// Subscribes to CAMERA_<NAME>, _INFO and _TO_WORLD. `bus` outlives the node.
  static Result<std::unique_ptr<EstimatorNode>> Create(Bus& bus,
                                                       const EstimatorConfig& config,
                                                       const std::string& process_name,
                                                       EstimateFunction estimate);

  /// The next detections get this seq.
  void CountFrom(int64_t seq) { seq_ = seq; }

 private:
  EstimatorNode(Bus& bus,
                const EstimatorConfig& config,
                const std::string& process_name,
                EstimateFunction estimate);
  Result<void> Subscribe();
  void OnImages(const Envelope& envelope, const images_t& message);
  void OnInfo(const camera_info_t& message);
  void OnPose(const rigid_transform_t& message);
  void ForgetPass();
  void ProcessPending();
  void Process(const DepthFrame& frame, const Pose& T_world_camera);
  void Report(const std::string& problem);

  static constexpr size_t kMaxPending = 16;  // Images that wait for poses or the calibration.

  Bus& bus_;
  EstimatorConfig config_;
  std::string name_;
  std::string channel_;  // Of the camera.
  EstimateFunction estimate_;
  std::optional<CameraModel> camera_;
  PoseBuffer poses_;
  std::deque<DepthFrame> pending_;
  SequenceTracker image_sequence_;
  int64_t num_passed_over_ = 0;  // Images since the last one counted that arrived but had no use.
  std::optional<int64_t> last_image_utime_;  // In this pass over time.
  int64_t seq_ = 0;
  std::string state_ = "ok";
};

/// For RunProcess: estimators of the tables [ppf] and [shot]. Errors: the config, or the models.
Result<std::unique_ptr<Node>> MakePpfNode(Bus& bus,
                                          ConfigReader& config,
                                          const ProcessOptions& options);
Result<std::unique_ptr<Node>> MakeShotNode(Bus& bus,
                                           ConfigReader& config,
                                           const ProcessOptions& options);

}  // namespace vantage
