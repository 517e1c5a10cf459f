#include "bus/conversions.h"

#include <algorithm>
#include <cmath>

#include "bus/message_time.h"
#include "common/format.h"

namespace vantage {
namespace {

constexpr size_t kMaxName = 64;
constexpr size_t kMaxDetections = 10'000;
constexpr double kDepthUnit = 0.001;  // m, of DEPTH_MM

bool IsName(const std::string& text) {
  return text.size() <= kMaxName && std::ranges::all_of(text, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == '-' || c == '.';
         });
}

Error BadName(const char* what, const std::string& text) {
  return {
      ErrorCode::kInvalidArgument,
      Format("detections_v2_t.%s is '%.80s', expected up to 64 letters, digits, '_', '-' or '.'",
             what,
             text.c_str())};
}

Error OutOfRange(const std::string& what, double value, const char* expected) {
  return {ErrorCode::kInvalidArgument,
          Format("%s is %g, expected %s", what.c_str(), value, expected)};
}

// Range checks are written so that NaN fails.
bool InUnitInterval(double value) { return value >= 0.0 && value <= 1.0; }
bool IsFiniteAndNotNegative(double value) { return std::isfinite(value) && value >= 0.0; }

void StorePose(const Pose& pose, double* trans, double* quat) {
  const Eigen::Quaterniond q(pose.linear());
  for (int i = 0; i < 3; ++i) trans[i] = pose.translation()[i];
  quat[0] = q.w();
  quat[1] = q.x();
  quat[2] = q.y();
  quat[3] = q.z();
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

// Finite, symmetric, no negative variance and no correlation beyond 1.
Result<Matrix6> CovarianceFromMessage(const std::string& owner, const double (&values)[36]) {
  const Matrix6 covariance = Eigen::Map<const RowMajor6>(values);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      const double value = covariance(row, column);
      const double variances = covariance(row, row) * covariance(column, column);
      const bool is_valid = std::isfinite(value) && covariance(row, row) >= 0.0 &&
                            value * value <= variances * (1.0 + 1e-9) &&
                            value == covariance(column, row);
      if (is_valid) continue;
      return OutOfRange(owner + Format("covariance[%d]", 6 * row + column),
                        value,
                        "a value of a symmetric matrix without negative variances");
    }
  }
  return covariance;
}

Result<Detection> DetectionFromMessage(const detection_v2_t& message) {
  if (message.model_id.empty() || !IsName(message.model_id)) {
    return BadName("detections.model_id", message.model_id);
  }
  Result<Pose> pose = PoseFromWire(message.trans, message.quat);
  if (!pose) return pose.error();
  const std::string name = "detections_v2_t.detections(" + message.model_id + ").";
  if (message.cluster < 0) return OutOfRange(name + "cluster", message.cluster, "0 or more");
  if (!IsFiniteAndNotNegative(message.mse)) {
    return OutOfRange(name + "mse", message.mse, "0 or more");
  }
  if (!InUnitInterval(message.inlier_fraction)) {
    return OutOfRange(name + "inlier_fraction", message.inlier_fraction, "0 to 1");
  }
  if (!InUnitInterval(message.verification_score)) {
    return OutOfRange(name + "verification_score", message.verification_score, "0 to 1");
  }
  const Result<Matrix6> covariance = CovarianceFromMessage(name, message.covariance);
  if (!covariance) return covariance.error();
  return Detection{.model_id = message.model_id,
                   .cluster = message.cluster,
                   .touches_border = message.touches_border != 0,
                   .T_camera_object = *pose,
                   .covariance = *covariance,
                   .mse = message.mse,
                   .inlier_fraction = message.inlier_fraction,
                   .verification_score = message.verification_score};
}

}  // namespace

Result<Pose> PoseFromMessage(const rigid_transform_t& message) {
  if (Result<void> timed = CheckUtime("rigid_transform_t.utime", message.utime); !timed) {
    return timed.error();
  }
  return PoseFromWire(message.trans, message.quat);
}

rigid_transform_t PoseToMessage(const Pose& T_world_camera, int64_t utime) {
  rigid_transform_t message{};
  message.utime = utime;
  StorePose(T_world_camera, message.trans, message.quat);
  return message;
}

Result<CameraModel> CameraFromMessage(const camera_info_t& message) {
  if (Result<void> timed = CheckUtime("camera_info_t.utime", message.utime); !timed) {
    return timed.error();
  }
  const CameraModel camera{.width = message.width,
                           .height = message.height,
                           .fx = message.fx,
                           .fy = message.fy,
                           .cx = message.cx,
                           .cy = message.cy};
  if (Result<void> valid = camera.Validate(); !valid) return valid.error();
  if (!(std::abs(message.depth_unit - kDepthUnit) <= 1e-9)) {
    return OutOfRange("camera_info_t.depth_unit", message.depth_unit, "0.001 m, as of DEPTH_MM");
  }
  const bool straight =
      std::ranges::all_of(message.distortion, [](double value) { return value == 0.0; });
  if (message.distortion_model != "none" && !straight) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("camera_info_t.distortion_model is '%.40s' with coefficients that are not 0, "
               "expected 'none': images must be undistorted before they are published",
               message.distortion_model.c_str())};
  }
  return camera;
}

camera_info_t CameraToMessage(const CameraModel& camera,
                              const CameraIdentity& identity,
                              int64_t utime,
                              int64_t seq,
                              const LensDistortion& distortion) {
  camera_info_t message{};
  message.utime = utime;
  message.seq = seq;
  message.name = identity.name;
  message.serial = identity.serial;
  message.frame = identity.frame;
  message.width = camera.width;
  message.height = camera.height;
  message.fx = camera.fx;
  message.fy = camera.fy;
  message.cx = camera.cx;
  message.cy = camera.cy;
  message.distortion_model = "none";
  if (!distortion.IsNone()) {
    message.distortion_model = "brown_conrady";
    message.distortion = {
        distortion.k1, distortion.k2, distortion.p1, distortion.p2, distortion.k3};
  }
  message.num_distortion = static_cast<int32_t>(message.distortion.size());
  message.depth_unit = kDepthUnit;
  message.registered = identity.registered ? 1 : 0;
  message.calibration_id = identity.calibration_id;
  return message;
}

Result<DetectionSet> DetectionsFromMessage(const detections_v2_t& message,
                                           const std::string& channel) {
  if (Result<void> timed = CheckUtime("detections_v2_t.utime", message.utime); !timed) {
    return timed.error();
  }
  if (!IsName(message.camera)) return BadName("camera", message.camera);
  if (!IsName(message.estimator)) return BadName("estimator", message.estimator);
  Result<Pose> T_world_camera = PoseFromWire(message.camera_trans, message.camera_quat);
  if (!T_world_camera) return T_world_camera.error();
  if (!IsFiniteAndNotNegative(message.compute_time)) {
    return OutOfRange("detections_v2_t.compute_time", message.compute_time, "0 s or more");
  }
  if (message.num_clusters < 0) {
    return OutOfRange("detections_v2_t.num_clusters", message.num_clusters, "0 or more");
  }
  if (message.detections.size() > kMaxDetections) {
    return OutOfRange("detections_v2_t.num_detections", message.num_detections, "10,000 at most");
  }
  DetectionSet set{.utime = message.utime,
                   .seq = message.seq,
                   .channel = channel,
                   .camera = message.camera,
                   .image_seq = message.image_seq,
                   .estimator = message.estimator,
                   .T_world_camera = *T_world_camera,
                   .compute_time = message.compute_time,
                   .num_clusters = message.num_clusters,
                   .detections = {}};
  set.detections.reserve(message.detections.size());
  for (const detection_v2_t& each : message.detections) {
    Result<Detection> detection = DetectionFromMessage(each);
    if (!detection) return detection.error();
    set.detections.push_back(std::move(detection).value());
  }
  return set;
}

detections_v2_t DetectionsToMessage(const DetectionSet& set) {
  detections_v2_t message{};
  message.utime = set.utime;
  message.seq = set.seq;
  message.camera = set.camera;
  message.image_seq = set.image_seq;
  message.estimator = set.estimator;
  StorePose(set.T_world_camera, message.camera_trans, message.camera_quat);
  message.compute_time = set.compute_time;
  message.num_clusters = set.num_clusters;
  message.num_detections = static_cast<int32_t>(set.detections.size());
  for (const Detection& each : set.detections) {
    detection_v2_t detection{};
    detection.model_id = each.model_id;
    detection.cluster = each.cluster;
    detection.touches_border = each.touches_border ? 1 : 0;
    StorePose(each.T_camera_object, detection.trans, detection.quat);
    Eigen::Map<RowMajor6>(detection.covariance) = each.covariance;
    detection.mse = each.mse;
    detection.inlier_fraction = each.inlier_fraction;
    detection.verification_score = each.verification_score;
    message.detections.push_back(std::move(detection));
  }
  return message;
}

}  // namespace vantage
