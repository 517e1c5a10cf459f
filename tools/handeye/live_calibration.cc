#include "tools/handeye/live_calibration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "bus/conversions.h"
#include "bus/gray_conversion.h"
#include "common/format.h"
#include "nodes/extrinsics_messages.h"
#include "perception/calibration/image_calibration.h"
#include "perception/calibration/next_pose.h"
#include "perception/calibration/target_pose.h"
#include "vantage/next_view_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kRestWindow = 150'000;  // us, as estimators have it
constexpr int64_t kRepeat = 1'000'000;    // us, between requests said again
constexpr size_t kLeastPoints = 8;        // of the target in an image
constexpr size_t kLeastToSolve = 4;       // views

bool IsNear(const Pose& a, const Pose& b, double distance, double turn) {
  return (a.translation() - b.translation()).norm() < distance &&
         GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) < turn;
}

double LongestHalfAxis(const Eigen::Matrix3d& covariance, double squared_radius) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, squared_radius * solver.eigenvalues().maxCoeff()));
}

}  // namespace

Result<std::unique_ptr<LiveCalibration>> LiveCalibration::Create(Bus& bus,
                                                                 const ExtrinsicsConfig& config) {
  if (!config.target) {
    return Error{ErrorCode::kInvalidArgument,
                 "[extrinsics.target] is missing: a live calibration looks at a target"};
  }
  Result<std::unique_ptr<TargetDetector>> detector = MakeTargetDetector(*config.target);
  if (!detector) return detector.error();
  std::unique_ptr<LiveCalibration> live(
      new LiveCalibration(bus, config, std::move(detector).value()));
  if (Result<void> subscribed = live->Subscribe(); !subscribed) return subscribed.error();
  return live;
}

LiveCalibration::LiveCalibration(Bus& bus,
                                 const ExtrinsicsConfig& config,
                                 std::unique_ptr<TargetDetector> detector)
    : bus_(bus),
      config_(config),
      detector_(std::move(detector)),
      target_points_(TargetPoints(*config.target)),
      asked_utime_(bus.NowUtime()) {}

Result<void> LiveCalibration::Subscribe() {
  const SubscribeOptions all{SubscribeOptions::Keep::kAll};
  const SubscribeOptions latest{SubscribeOptions::Keep::kLatest};
  const std::string channel = "CAMERA_" + config_.camera;
  Result<void> done = bus_.Subscribe<rigid_transform_t>(
      config_.hand_channel, all, [this](const Envelope&, const rigid_transform_t& message) {
        OnHand(message);
      });
  if (done) {
    done = bus_.Subscribe<camera_info_t>(
        channel + "_INFO", latest, [this](const Envelope&, const camera_info_t& message) {
          OnInfo(message);
        });
  }
  if (done) {
    done = bus_.Subscribe<images_t>(
        channel, latest, [this](const Envelope&, const images_t& message) { OnImages(message); });
  }
  if (done) {
    done = bus_.Subscribe<arm_status_t>(
        "ARM_STATUS", all, [this](const Envelope&, const arm_status_t& message) {
          OnArmStatus(message);
        });
  }
  return done;
}

void LiveCalibration::OnHand(const rigid_transform_t& message) {
  const Result<Pose> T_base_hand = PoseFromMessage(message);
  if (!T_base_hand) return;
  if (hands_.Add(message.utime, *T_base_hand)) pending_.reset();
  // A robot that says nothing of itself has arrived when it rests where it was sent.
  constexpr double kThereDistance = 0.002;      // m
  constexpr double kThereTurn = 0.2 * kDegree;  // rad
  if (asked_ && !arrived_utime_ && IsNear(*T_base_hand, *asked_, kThereDistance, kThereTurn) &&
      hands_.RestsAt(message.utime - kRestWindow, kRestWindow)) {
    arrived_utime_ = message.utime - kRestWindow;
  }
  ProcessPending();
}

void LiveCalibration::OnInfo(const camera_info_t& message) {
  const Result<CameraModel> camera = CameraFromMessage(message);
  if (camera) {
    camera_ = *camera;
  } else {
    remark_ = "CAMERA_" + config_.camera + "_INFO: " + camera.error().message;
  }
}

void LiveCalibration::OnImages(const images_t& message) {
  if (finished_ || (pending_ && pending_->utime + kRestWindow > message.utime)) return;
  pending_ = message;
  ProcessPending();
}

void LiveCalibration::OnArmStatus(const arm_status_t& message) {
  if (!asked_ || message.view_seq != request_seq_ || arrived_utime_) return;
  if (message.state == arm_status_t::REFUSED) {
    std::printf("  refused: %s\n", message.reason.c_str());
    GoOn();
  } else if (message.state == arm_status_t::RESTING) {
    arrived_utime_ = message.utime;
  }
}

// Whether the hand was at rest is known only when poses of some time after the image are there.
void LiveCalibration::ProcessPending() {
  const std::optional<int64_t> newest = hands_.Newest();
  if (finished_ || !pending_ || !newest || !camera_ || *newest < pending_->utime + kRestWindow) {
    return;
  }
  const images_t message = std::move(*pending_);
  pending_.reset();
  if (asked_ && (!arrived_utime_ || message.utime < *arrived_utime_)) return;
  if (!hands_.RestsAt(message.utime, kRestWindow)) return;
  if (const std::optional<Pose> T_base_hand = hands_.At(message.utime)) {
    TakeView(message, *T_base_hand);
  }
}

void LiveCalibration::TakeView(const images_t& message, const Pose& T_base_hand) {
  const Result<GrayFrame> frame = GrayFrameFromMessage(message);
  if (!frame) {
    remark_ = "CAMERA_" + config_.camera + ": " + frame.error().message;
    return;
  }
  ImageView view;
  view.name = Format("view %zu", views_.size() + 1);
  view.utime = message.utime;
  view.T_base_hand = T_base_hand;
  view.points = detector_->Detect(frame->image);
  if (view.points.size() < std::min(kLeastPoints, target_points_.size())) {
    remark_ = Format("%zu points of the target are seen", view.points.size());
    // Waiting helps at the start alone, where somebody may still be putting it there.
    if (!T_base_start_) return;
    std::printf("  the target is not seen from there\n");
    return GoOn();
  }
  last_utime_ = message.utime;
  if (!T_base_start_) {
    T_base_start_ = T_base_hand;
    tried_.push_back(T_base_hand);
    first_poses_ = FirstHandPoses(T_base_hand, config_.live.first_turn);
    std::ranges::reverse(first_poses_);
  }
  views_.push_back(std::move(view));
  Solve();
  GoOn();
}

double LiveCalibration::translation_bound() const {
  return LongestHalfAxis(result_->covariance.bottomRightCorner<3, 3>(), result_->squared_radius_95);
}

double LiveCalibration::rotation_bound() const {
  return LongestHalfAxis(result_->covariance.topLeftCorner<3, 3>(), result_->squared_radius_95);
}

bool LiveCalibration::IsGoodEnough() const {
  return result_ && result_->observability.is_sufficient &&
         views_.size() >= static_cast<size_t>(config_.live.least_views) &&
         translation_bound() <= config_.live.translation_bound &&
         rotation_bound() <= config_.live.rotation_bound;
}

void LiveCalibration::Solve() {
  std::printf("view %zu: %zu points", views_.size(), views_.back().points.size());
  if (views_.size() >= kLeastToSolve) {
    ImageCalibrationOptions options;
    options.noise = config_.noise;
    Result<HandEyeResult> solved =
        CalibrateFromImages(config_.setup, views_, *camera_, LensDistortion(), options);
    if (solved) {
      result_ = std::move(solved).value();
      const Observability& observability = result_->observability;
      const HandEyeFile calibration = MakeHandEyeFile(*result_, config_.camera, last_utime_);
      const Result<void> sent = bus_.Publish(
          "HANDEYE_RESULT",
          HandEyeToMessage(
              calibration, result_seq_++, observability.is_sufficient ? "" : observability.reason));
      if (!sent) remark_ = sent.error().message;
      std::printf(", known to %.3f mm and %.4f deg (95 %%)",
                  1e3 * translation_bound(),
                  rotation_bound() / kDegree);
      if (!observability.is_sufficient) std::printf("; %s", observability.reason.c_str());
    } else {
      std::printf("; %s", solved.error().message.c_str());
    }
  }
  std::printf("\n");
  std::fflush(stdout);
}

void LiveCalibration::GoOn() {
  if (IsGoodEnough()) return Finish("the 95 % bounds are met");
  if (views_.size() >= static_cast<size_t>(config_.live.max_views)) {
    return Finish("the most views are taken, and the 95 % bounds are not met");
  }
  const std::optional<Pose> next = ChooseNext();
  if (!next) {
    return Finish(
        Format("no pose is left from which the target would be seen within [extrinsics.live] "
               "max_distance_m and max_turn_deg, and the 95 %% bounds are not met with %zu views",
               views_.size()));
  }
  Ask(*next);
}

bool LiveCalibration::WasTried(const Pose& T_base_hand) const {
  constexpr double kDistance = 0.01;       // m
  constexpr double kTurn = 3.0 * kDegree;  // rad
  return std::ranges::any_of(
      tried_, [&](const Pose& each) { return IsNear(each, T_base_hand, kDistance, kTurn); });
}

std::optional<Pose> LiveCalibration::ChooseNext() {
  if (!result_ || !result_->observability.is_sufficient) {
    if (first_poses_.empty() && !result_) return std::nullopt;
    if (!first_poses_.empty()) {
      const Pose next = first_poses_.back();
      first_poses_.pop_back();
      choice_ = "a turn in place, to begin with";
      gain_ = 0.0;
      return next;
    }
  }
  const HandEyeResult& known = *result_;
  const Pose start = config_.setup == HandEyeSetup::kEyeInHand
                         ? *T_base_start_
                         : T_base_start_->inverse(Eigen::Isometry);
  const double distance =
      ((start * known.T_x).inverse(Eigen::Isometry) * known.T_y.translation()).norm();
  std::vector<Pose> candidates = HandPoseCandidates(
      known.setup, known.T_x, known.T_y, distance, *T_base_start_, config_.live.limits);
  std::erase_if(candidates, [this](const Pose& each) { return WasTried(each); });
  const std::vector<NextPose> ranked =
      RankNextPoses(known, candidates, *camera_, target_points_, config_.noise);
  if (ranked.empty() || !ranked.front().sees_target) return std::nullopt;
  gain_ = ranked.front().expected_sigma;
  choice_ = Format("of %zu poses the one after which the camera would be known best, to %.3f mm",
                   candidates.size(),
                   1e3 * gain_);
  return candidates[ranked.front().candidate];
}

void LiveCalibration::Ask(const Pose& T_base_hand) {
  asked_ = T_base_hand;
  tried_.push_back(T_base_hand);
  arrived_utime_.reset();
  asked_utime_ = bus_.NowUtime();
  // Counts up from the first request's time, so that a second run's are told from the first's.
  request_seq_ = request_seq_ == 0 ? asked_utime_ : request_seq_ + 1;
  remark_ = "waiting for the robot to arrive";
  PublishRequest();
}

void LiveCalibration::PublishRequest() {
  repeated_utime_ = bus_.NowUtime();
  next_view_t request{};
  request.utime = last_utime_;
  request.seq = request_seq_;
  request.criterion = "hand-eye";
  request.selected = finished_ ? -1 : 0;
  request.reason = finished_ ? remark_ : choice_;
  if (!finished_) {
    view_candidate_t candidate{};
    const rigid_transform_t wire = PoseToMessage(*asked_, 0);
    std::copy_n(wire.trans, 3, candidate.trans);
    std::copy_n(wire.quat, 4, candidate.quat);
    candidate.gain = gain_;
    candidate.reachable = static_cast<int8_t>(true);
    request.candidates = {candidate};
  }
  request.num_candidates = static_cast<int32_t>(request.candidates.size());
  if (Result<void> sent = bus_.Publish("NEXT_HAND_POSE", request); !sent) {
    remark_ = sent.error().message;
  }
}

void LiveCalibration::Poll() {
  if (finished_) return;
  const int64_t now = bus_.NowUtime();
  if (now - asked_utime_ > static_cast<int64_t>(1e6 * config_.live.patience_s)) {
    if (!T_base_start_) return Finish("nothing to start from: " + remark_);
    std::printf("  given up: %s\n", remark_.c_str());
    return GoOn();
  }
  if (asked_ && !arrived_utime_ && now - repeated_utime_ > kRepeat) PublishRequest();
}

void LiveCalibration::Finish(const std::string& remark) {
  finished_ = true;
  remark_ = remark;
  ++request_seq_;
  PublishRequest();
}

}  // namespace vantage
