#include "nodes/extrinsics_messages.h"

#include <algorithm>

#include "bus/conversions.h"

namespace vantage {
namespace {

void CopyPose(const Pose& pose, double (&trans)[3], double (&quat)[4]) {
  const rigid_transform_t wire = PoseToMessage(pose, 0);
  std::copy_n(wire.trans, 3, trans);
  std::copy_n(wire.quat, 4, quat);
}

int8_t StateOnWire(DriftReport::State state) {
  switch (state) {
    case DriftReport::State::kHolds:
      return handeye_check_t::HOLDS;
    case DriftReport::State::kDrifted:
      return handeye_check_t::DRIFTED;
    case DriftReport::State::kDistorted:
      return handeye_check_t::DISTORTED;
    case DriftReport::State::kUnknown:
      break;
  }
  return handeye_check_t::UNKNOWN;
}

}  // namespace

handeye_result_t HandEyeToMessage(const HandEyeFile& calibration,
                                  int64_t seq,
                                  const std::string& reason) {
  handeye_result_t message{};
  message.utime = calibration.created_utime;
  message.seq = seq;
  message.camera = calibration.camera;
  message.setup = calibration.setup == HandEyeSetup::kEyeInHand ? handeye_result_t::EYE_IN_HAND
                                                                : handeye_result_t::EYE_TO_HAND;
  CopyPose(calibration.T_x, message.trans, message.quat);
  CopyPose(calibration.T_y, message.target_trans, message.target_quat);
  for (Eigen::Index i = 0; i < 36; ++i) {
    message.covariance[i] = calibration.covariance(i / 6, i % 6);
  }
  message.squared_radius_95 = calibration.squared_radius_95;
  message.noise_scale = calibration.noise_scale;
  message.num_views = calibration.num_views;
  message.num_outliers = calibration.num_outliers;
  message.rotation_rms = calibration.rotation_rms;
  message.translation_rms = calibration.translation_rms;
  message.pixel_rms = calibration.pixel_rms;
  message.robot_scale = calibration.robot_scale;
  message.time_offset = calibration.time_offset;
  message.sufficient = static_cast<int8_t>(reason.empty());
  message.reason = reason;
  return message;
}

handeye_check_t DriftToMessage(const DriftReport& report,
                               const HandEyeFile& calibration,
                               const std::string& source,
                               int64_t utime,
                               int64_t seq) {
  handeye_check_t message{};
  message.utime = utime;
  message.seq = seq;
  message.camera = calibration.camera;
  message.source = source;
  message.state = StateOnWire(report.state);
  message.num_views = report.num_views;
  message.rotation = report.rotation;
  message.rotation_sigma = report.rotation_sigma;
  message.translation = report.translation;
  message.translation_sigma = report.translation_sigma;
  message.pixel_rms = report.pixel_rms;
  message.expected_pixel_rms = calibration.pixel_rms;
  message.reason = report.reason;
  return message;
}

}  // namespace vantage
