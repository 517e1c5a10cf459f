#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "perception/model/object_model.h"
#include "tests/bench/pose_comparison/stage_clock.h"

namespace vantage {

/// One object alone in an image: what every estimator gets.
struct SegmentedView {
  const CameraModel& camera;
  const DepthImage& depth;              ///< Nothing but the object.
  std::vector<Eigen::Vector3f> points;  ///< p_camera of its pixels, m, row by row.
};

/// An estimator of the pose of one model that it was trained for.
class ComparedEstimator {
 public:
  virtual ~ComparedEstimator() = default;
  /// T_camera_object; nothing when it found none. The same for equal views.
  /// @param stages gets all of the time, scene preparation too.
  virtual std::optional<Pose> Estimate(const SegmentedView& view, StageClock* stages) = 0;
};

struct EstimatorKind {
  std::string name;
  bool is_peer = true;  ///< Other people's.
  std::unique_ptr<ComparedEstimator> (*make)(const ObjectModel&) = nullptr;
};

/// Ours first.
std::span<const EstimatorKind> EstimatorKinds();

std::unique_ptr<ComparedEstimator> MakePpf(const ObjectModel& model);
std::unique_ptr<ComparedEstimator> MakeShot(const ObjectModel& model);
std::unique_ptr<ComparedEstimator> MakePclPpf(const ObjectModel& model);
std::unique_ptr<ComparedEstimator> MakePclPpfFine(const ObjectModel& model);
std::unique_ptr<ComparedEstimator> MakePclPrerejective(const ObjectModel& model);
std::unique_ptr<ComparedEstimator> MakePclSacIa(const ObjectModel& model);
std::unique_ptr<ComparedEstimator> MakeOpenCvPpf(const ObjectModel& model);

}  // namespace vantage
