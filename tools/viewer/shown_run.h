#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/so3.h"
#include "vantage/detections_v2_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {

/// One orientation that an object may have.
struct ShownPeak {
  Eigen::Quaterniond q_world_object = Eigen::Quaterniond::Identity();
  double weight = 0.0;                                   ///< [0, 1]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< rad^2, world axes
};

/// An object as OBJECTS tells it.
struct ShownObject {
  int32_t instance = 0;
  std::string model_id;
  int state = 0;                                                  ///< object_estimate_v3_t's
  Eigen::Vector3d position = Eigen::Vector3d::Zero();             ///< m, T_world_object
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Zero();  ///< m^2
  std::vector<ShownPeak> peaks;  ///< the heaviest first, at least one
  std::optional<Pose> refined;   ///< T_world_object
  double entropy = 0.0;          ///< nat
  int num_views = 0;
  bool converged = false;
  double last_change = -1.0;  ///< rad; -1: none yet

  /// T_world_object by a peak; the refined one for the first where there is one.
  [[nodiscard]] Pose PoseOfPeak(size_t peak) const;
};

struct ShownObjects {
  int64_t utime = 0;  ///< us since the epoch; 0: none came
  int num_viewpoints = 0;
  bool finished = false;
  std::vector<ShownObject> objects;

  /// Null when there is none.
  [[nodiscard]] const ShownObject* Find(int32_t instance) const;
};

struct ShownDetection {
  std::string model_id;
  int cluster = 0;
  double score = 0.0;  ///< verification, [0, 1]
  Pose T_world_object = Pose::Identity();
};

/// What one estimator found in one image.
struct ShownDetections {
  int64_t utime = 0;    ///< us since the epoch, of the image; 0: none came
  int64_t seq = 0;      ///< counts sets of the estimator
  std::string channel;  ///< e.g. "DETECTIONS_PPF"
  Pose T_world_camera = Pose::Identity();
  std::vector<ShownDetection> detections;
};

struct ShownCandidate {
  Pose T_world_camera = Pose::Identity();
  double gain = 0.0;  ///< the criterion's unit
  bool reachable = false;
};

/// The latest decision about the next view.
struct ShownPlan {
  int64_t utime = 0;  ///< us since the epoch; 0: none came
  std::string criterion;
  std::string reason;
  size_t num_offered = 0;                  ///< in the message
  std::vector<ShownCandidate> candidates;  ///< those that are sound, up to a number
  std::optional<ShownCandidate> chosen;
};

/// What became of one object at one viewpoint.
struct StepEntry {
  std::string model_id;
  std::vector<double> peak_weights;  ///< after it, the heaviest first
  std::optional<Pose> detection;     ///< T_world_object that this viewpoint's image told
  double score = 0.0;                ///< of that detection
  int num_detections = 0;            ///< of this viewpoint that went into the estimate
  double angle = 0.0;                ///< rad, from the detection to the nearest peak after it
  size_t nearest_peak = 0;           ///< which one that is
  double distance = 0.0;             ///< m, from the detection's position to the estimate's
};

/// One viewpoint of a run.
struct ShownStep {
  int viewpoint = 0;                     ///< from 0
  int64_t utime = 0;                     ///< us since the epoch, of its OBJECTS
  std::optional<Pose> T_world_camera;    ///< where the image was taken
  std::map<int32_t, StepEntry> objects;  ///< by instance
};

/// Each leaves out what is not finite, no rotation, or more than is shown.
ShownObjects ObjectsFromMessage(const object_estimates_v3_t& message);
ShownPlan PlanFromMessage(const next_view_t& message);
/// Nothing when the message fails its checks.
std::optional<ShownDetections> ShownFromMessage(const detections_v2_t& message,
                                                const std::string& channel);

}  // namespace vantage
