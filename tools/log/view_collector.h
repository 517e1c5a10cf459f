#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bus/event_log_reader.h"
#include "common/camera_model.h"
#include "common/pose_buffer.h"
#include "common/result.h"
#include "vantage/images_t.hpp"

namespace vantage {

/// Images that a camera sent together, and what is known of the camera then.
struct CameraView {
  std::string camera;  ///< <NAME> of the channels
  int64_t utime = 0;   ///< us since the epoch, of the exposure
  int64_t seq = -1;    ///< -1: the sender does not say
  images_t images{};
  std::optional<CameraModel> model;    ///< as CAMERA_<NAME>_INFO said last
  bool registered = false;             ///< depth and color show the same from pixel to pixel
  std::optional<Pose> T_world_camera;  ///< m
};

/// Puts images together with the poses, which come before or after them in a log: an image waits
/// until there is a pose behind it, at most kPatience.
class ViewCollector {
 public:
  using Visit = std::function<Result<void>(const CameraView&)>;
  explicit ViewCollector(Visit visit) : visit_(std::move(visit)) {}

  /// Errors: those of the visit.
  Result<void> Add(const LogEventView& event, bool wanted);
  /// Visits what still waits.
  Result<void> Finish();
  [[nodiscard]] int64_t num_malformed() const { return num_malformed_; }

  static constexpr int64_t kPatience = 500'000;            ///< us of the log
  static constexpr size_t kMostBytes = size_t{64} << 20U;  ///< of images that wait
  static constexpr size_t kMostCameras = 1000;             ///< names come from outside

 private:
  struct Camera {
    PoseBuffer poses;
    std::optional<CameraModel> model;
    bool registered = false;
  };
  struct Waiting {
    CameraView view;
    int64_t event_utime = 0;
    size_t bytes = 0;
  };

  Camera* Find(const std::string& name);
  Result<void> VisitFirst();

  Visit visit_;
  std::map<std::string, Camera> cameras_;
  std::deque<Waiting> waiting_;
  size_t waiting_bytes_ = 0;
  int64_t num_malformed_ = 0;
};

}  // namespace vantage
