#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bus/sequence_tracker.h"
#include "common/camera_model.h"
#include "common/pose_buffer.h"
#include "common/so3.h"
#include "tools/viewer/scene_cloud.h"
#include "tools/viewer/shown_run.h"
#include "vantage/images_t.hpp"
#include "vantage/orientation_histogram_t.hpp"

namespace vantage {

/// A camera as far as its messages tell.
struct ShownCamera {
  std::optional<CameraModel> model;
  std::optional<Pose> T_world_camera;  ///< the latest
  std::vector<Eigen::Vector3f> path;   ///< m, world; where it was
  std::string state;                   ///< of its driver, in a word; empty: not heard
};

/// What the viewer shows, made of messages of a bus or a log, one after the other. What comes in is
/// checked, and bounded in number; what fails is counted. Copies are cheap: bulk is shared.
class ViewerState {
 public:
  /// What there may be of each; the rest is left out.
  static constexpr size_t kMaxObjects = 64;
  static constexpr size_t kMaxPeaks = 12;
  static constexpr size_t kMaxDetections = 200;
  static constexpr size_t kMaxCandidates = 2'000;
  static constexpr size_t kMaxSteps = 500;
  static constexpr size_t kMaxCameras = 8;
  static constexpr size_t kMaxPath = 4'000;
  static constexpr size_t kMaxProcesses = 64;

  ViewerState() = default;
  explicit ViewerState(const SceneCloud::Parameters& cloud) : cloud_(cloud) {}

  /// Takes a message of any channel; those of other people are passed over.
  /// @param utime us since the epoch at which it came
  void Apply(const std::string& channel, int64_t utime, std::span<const std::byte> bytes);

  [[nodiscard]] int64_t utime() const { return utime_; }  ///< of the latest message
  [[nodiscard]] int64_t num_lost() const { return num_lost_; }
  [[nodiscard]] int64_t num_refused() const { return num_refused_; }  ///< failed their checks
  [[nodiscard]] int64_t num_used() const { return num_used_; }        ///< messages of ours
  [[nodiscard]] const SceneCloud& cloud() const { return cloud_; }
  [[nodiscard]] const std::map<std::string, ShownCamera>& cameras() const { return cameras_; }
  [[nodiscard]] const ShownObjects& objects() const { return objects_; }
  [[nodiscard]] const std::vector<ShownStep>& steps() const { return steps_; }
  [[nodiscard]] const ShownDetections& detections() const { return detections_; }
  [[nodiscard]] const ShownPlan& plan() const { return plan_; }
  /// Empty: not heard.
  [[nodiscard]] const std::string& arm_state() const { return arm_state_; }
  /// Processes that do not say "ok", with what they say.
  [[nodiscard]] const std::map<std::string, std::string>& processes() const { return processes_; }
  /// Null when there is none.
  [[nodiscard]] std::shared_ptr<const orientation_histogram_t> histogram(int32_t instance) const;

 private:
  struct CameraInput {
    PoseBuffer poses;
    std::deque<std::shared_ptr<const images_t>> waiting;  // For poses of after the exposure.
    std::optional<Pose> last_cloud;  // Where the camera was when it last added to the cloud.
  };

  void OnCameraChannel(const std::string& channel, std::span<const std::byte> bytes);
  void OnPose(const std::string& name, std::span<const std::byte> bytes);
  void OnImages(const std::string& name, std::span<const std::byte> bytes);
  void AddResting(const std::string& name);
  void OnObjects(std::span<const std::byte> bytes);
  void OnDetections(const std::string& channel, std::span<const std::byte> bytes);
  void OnHistogram(std::span<const std::byte> bytes);
  void OnNextView(std::span<const std::byte> bytes);
  void OnArm(std::span<const std::byte> bytes);
  void OnProcess(std::span<const std::byte> bytes);
  void AddStep(int32_t num_viewpoints);
  // The camera of a name; null when there are too many.
  ShownCamera* CameraNamed(const std::string& name);
  // Decodes, and counts what is refused and what is missing before it.
  template <class Message>
  std::optional<Message> Take(const std::string& channel, std::span<const std::byte> bytes);

  int64_t utime_ = 0;
  int64_t num_lost_ = 0;
  int64_t num_refused_ = 0;
  int64_t num_used_ = 0;
  SequenceTracker sequence_;
  SceneCloud cloud_;
  std::map<std::string, ShownCamera> cameras_;
  std::map<std::string, CameraInput> inputs_;
  ShownObjects objects_;
  std::vector<ShownStep> steps_;
  ShownDetections detections_;
  std::deque<ShownDetections> recent_;  // Of all estimators, for the sources of OBJECTS.
  ShownPlan plan_;
  std::string arm_state_;
  std::map<std::string, std::string> processes_;
  std::map<int32_t, std::shared_ptr<const orientation_histogram_t>> histograms_;
};

}  // namespace vantage
