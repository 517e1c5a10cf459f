#include "nodes/extrinsics_node.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <span>
#include <utility>

#include "bus/conversions.h"
#include "common/format.h"
#include "nodes/extrinsics_messages.h"
#include "perception/calibration/target_pose.h"

namespace vantage {
namespace {

constexpr int64_t kRestWindow = 150'000;    // us, as estimators have it
constexpr int64_t kCameraPeriod = 100'000;  // us, of a camera that stands still
constexpr int64_t kSecond = 1'000'000;      // us
constexpr int64_t kLookPeriod = 500'000;    // us, between images in which the target is sought
constexpr double kSameThing = 0.05;         // m, between positions of one object
constexpr int kMostThings = 8;

/// True once a period, and after a clock that was set back.
bool IsDue(std::optional<int64_t>* last, int64_t now, int64_t period) {
  if (*last && now >= **last && now < **last + period) return false;
  *last = now;
  return true;
}

HandEyeResult ResultOf(const HandEyeFile& calibration) {
  HandEyeResult result;
  result.setup = calibration.setup;
  result.T_x = calibration.T_x;
  result.T_y = calibration.T_y;
  result.covariance = calibration.covariance;
  result.target_covariance = calibration.target_covariance;
  result.squared_radius_95 = calibration.squared_radius_95;
  return result;
}

DriftCheckParameters CheckOf(const ExtrinsicsConfig& config, const HandEyeFile& calibration) {
  DriftCheckParameters parameters = config.check;
  parameters.noise = config.noise;
  parameters.noise_scale = calibration.noise_scale;
  return parameters;
}

const char* NameOf(HandEyeSetup setup) {
  return setup == HandEyeSetup::kEyeInHand ? "eye in hand" : "eye to hand";
}

}  // namespace

Result<std::unique_ptr<ExtrinsicsNode>> ExtrinsicsNode::Create(Bus& bus,
                                                               const ExtrinsicsConfig& config,
                                                               const HandEyeFile& calibration) {
  if (calibration.camera != config.camera || calibration.setup != config.setup) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is of camera %s, %s; [extrinsics] is of %s, %s",
                        config.calibration.c_str(),
                        calibration.camera.c_str(),
                        NameOf(calibration.setup),
                        config.camera.c_str(),
                        NameOf(config.setup))};
  }
  std::unique_ptr<ExtrinsicsNode> node(new ExtrinsicsNode(bus, config, calibration));
  if (config.target) {
    Result<std::unique_ptr<TargetDetector>> detector = MakeTargetDetector(*config.target);
    if (!detector) return detector.error();
    node->detector_ = std::move(detector).value();
  }
  if (Result<void> subscribed = node->Subscribe(); !subscribed) return subscribed.error();
  return node;
}

ExtrinsicsNode::ExtrinsicsNode(Bus& bus,
                               const ExtrinsicsConfig& config,
                               const HandEyeFile& calibration)
    : bus_(bus),
      config_(config),
      calibration_(calibration),
      channel_("CAMERA_" + config.camera),
      check_(CheckOf(config, calibration), ResultOf(calibration), calibration.pixel_rms) {
  if (calibration.intrinsics) {
    camera_ = calibration.intrinsics;
    distortion_ = calibration.distortion;
  }
}

Result<void> ExtrinsicsNode::Subscribe() {
  const SubscribeOptions all{SubscribeOptions::Keep::kAll};
  const SubscribeOptions latest{SubscribeOptions::Keep::kLatest};
  Result<void> done = bus_.Subscribe<rigid_transform_t>(
      config_.hand_channel, all, [this](const Envelope&, const rigid_transform_t& message) {
        OnHand(message);
      });
  if (done && detector_) {
    done = bus_.Subscribe<images_t>(
        channel_, latest, [this](const Envelope&, const images_t& message) { OnImages(message); });
  }
  if (done && detector_ && !camera_) {
    done = bus_.Subscribe<camera_info_t>(
        channel_ + "_INFO", latest, [this](const Envelope&, const camera_info_t& message) {
          OnInfo(message);
        });
  }
  if (done && !config_.detections.empty()) {
    done = bus_.Subscribe<detections_v2_t>(
        config_.detections, all, [this](const Envelope& envelope, const detections_v2_t& message) {
          OnDetections(envelope.channel, message);
        });
  }
  if (done && config_.setup == HandEyeSetup::kEyeInHand) {
    done = bus_.Subscribe<next_view_t>(
        "NEXT_VIEW", all, [this](const Envelope&, const next_view_t& message) {
          OnNextView(message);
        });
  }
  return done;
}

void ExtrinsicsNode::Report(const std::string& problem) {
  problem_ = problem;
  const bool warns = report_ && (report_->state == DriftReport::State::kDrifted ||
                                 report_->state == DriftReport::State::kDistorted);
  const std::string state = !problem.empty() ? problem : warns ? report_->reason : "ok";
  if (state == state_) return;
  state_ = state;
  bus_.SetState(state);
}

void ExtrinsicsNode::OnHand(const rigid_transform_t& message) {
  Result<Pose> T_base_hand = PoseFromMessage(message);
  if (!T_base_hand) return Report(config_.hand_channel + ": " + T_base_hand.error().message);
  T_base_hand->translation() *= calibration_.robot_scale;
  // The image of utime t shows the hand of t + offset.
  const int64_t utime =
      message.utime - static_cast<int64_t>(std::llround(1e6 * calibration_.time_offset));
  if (hands_.Add(utime, *T_base_hand)) {
    pending_.clear();
    pending_detections_.clear();
  }
  if (config_.setup == HandEyeSetup::kEyeInHand) {
    PublishCamera(config_.T_world_base * *T_base_hand * calibration_.T_x, utime);
  }
  ProcessPending();
  Tick();
}

void ExtrinsicsNode::PublishCamera(const Pose& T_world_camera, int64_t utime) {
  const Result<void> sent =
      bus_.Publish(channel_ + "_TO_WORLD", PoseToMessage(T_world_camera, utime));
  Report(sent ? "" : sent.error().message);
}

/// The planner's views as poses of the hand, for robots that know no camera.
void ExtrinsicsNode::OnNextView(const next_view_t& message) {
  next_view_t asked = message;
  const Pose T_camera_hand = calibration_.T_x.inverse(Eigen::Isometry);
  for (view_candidate_t& candidate : asked.candidates) {
    const Result<Pose> T_world_camera = PoseFromWire(std::span<const double, 3>(candidate.trans),
                                                     std::span<const double, 4>(candidate.quat));
    if (!T_world_camera) return Report("NEXT_VIEW: " + T_world_camera.error().message);
    Pose T_base_hand =
        config_.T_world_base.inverse(Eigen::Isometry) * *T_world_camera * T_camera_hand;
    T_base_hand.translation() /= calibration_.robot_scale;
    const rigid_transform_t wire = PoseToMessage(T_base_hand, 0);
    std::copy_n(wire.trans, 3, candidate.trans);
    std::copy_n(wire.quat, 4, candidate.quat);
  }
  if (Result<void> sent = bus_.Publish("NEXT_HAND_POSE", asked); !sent) {
    Report(sent.error().message);
  }
}

void ExtrinsicsNode::OnInfo(const camera_info_t& message) {
  const Result<CameraModel> camera = CameraFromMessage(message);
  if (!camera) return Report(channel_ + "_INFO: " + camera.error().message);
  camera_ = *camera;
}

void ExtrinsicsNode::OnImages(const images_t& message) {
  Result<GrayFrame> frame = GrayFrameFromMessage(message);
  if (!frame) return Report(channel_ + ": " + frame.error().message);
  pending_.push_back(std::move(frame).value());
  if (pending_.size() > kMaxPending) pending_.pop_front();
  ProcessPending();
  Tick();
}

void ExtrinsicsNode::OnDetections(const std::string& channel, const detections_v2_t& message) {
  Result<DetectionSet> set = DetectionsFromMessage(message, channel);
  if (!set) return Report(channel + ": " + set.error().message);
  if (set->camera != config_.camera) return;
  pending_detections_.push_back(std::move(set).value());
  if (pending_detections_.size() > kMaxPending) pending_detections_.pop_front();
  ProcessPending();
  Tick();
}

std::optional<Pose> ExtrinsicsNode::HandAtRest(int64_t utime) const {
  return hands_.RestsAt(utime, kRestWindow) ? hands_.At(utime) : std::nullopt;
}

// Whether the hand was at rest is known only when poses of some time after the image are there.
void ExtrinsicsNode::ProcessPending() {
  const std::optional<int64_t> newest = hands_.Newest();
  if (!newest) return;
  const auto is_known = [&](int64_t utime) { return utime + kRestWindow <= *newest; };
  while (!pending_.empty() && is_known(pending_.front().utime)) {
    const GrayFrame frame = std::move(pending_.front());
    pending_.pop_front();
    const std::optional<Pose> T_base_hand = HandAtRest(frame.utime);
    if (T_base_hand && IsDue(&looked_utime_, frame.utime, kLookPeriod)) {
      LookForTarget(frame, *T_base_hand);
    }
  }
  while (!pending_detections_.empty() && is_known(pending_detections_.front().utime)) {
    const DetectionSet set = std::move(pending_detections_.front());
    pending_detections_.pop_front();
    const std::optional<Pose> T_base_hand = HandAtRest(set.utime);
    // A target tells more than objects do.
    if (!T_base_hand || saw_target_) continue;
    std::map<int, const Detection*> best;  // Of each segment.
    for (const Detection& detection : set.detections) {
      const Detection*& other = best[detection.cluster];
      if (other == nullptr || detection.verification_score > other->verification_score) {
        other = &detection;
      }
    }
    for (const auto& [cluster, detection] : best) AddDetection(*detection, *T_base_hand);
    checked_utime_ = set.utime;
  }
}

void ExtrinsicsNode::LookForTarget(const GrayFrame& frame, const Pose& T_base_hand) {
  if (!camera_) return Report("images come, but no calibration on " + channel_ + "_INFO");
  if (frame.image.width != camera_->width || frame.image.height != camera_->height) {
    return Report(Format("%s has %d x %d px, the calibration is of %d x %d px",
                         channel_.c_str(),
                         frame.image.width,
                         frame.image.height,
                         camera_->width,
                         camera_->height));
  }
  const std::vector<TargetPoint> points = detector_->Detect(frame.image);
  // Fewer tell little, and are the likeliest to be wrong.
  constexpr size_t kLeastPoints = 8;
  if (points.size() < std::min(kLeastPoints, TargetPoints(*config_.target).size())) return;
  const Result<std::vector<TargetPose>> poses =
      FindTargetPoses(points, *camera_, distortion_, config_.noise.pixel);
  if (!poses) return;
  // Of two poses that explain the image alike, the one that the calibration says.
  const Pose A = config_.setup == HandEyeSetup::kEyeInHand ? T_base_hand
                                                           : T_base_hand.inverse(Eigen::Isometry);
  const Eigen::Quaterniond expected(
      ((A * calibration_.T_x).inverse(Eigen::Isometry) * calibration_.T_y).linear());
  const TargetPose& pose =
      *std::ranges::min_element(*poses, {}, [&expected](const TargetPose& each) {
        return GeodesicAngle(expected, Eigen::Quaterniond(each.T_camera_target.linear()));
      });
  saw_target_ = true;
  check_.Add({.T_base_hand = T_base_hand,
              .T_camera_target = pose.T_camera_target,
              .camera_covariance = pose.covariance,
              .pixel_rms = pose.pixel_rms});
  checked_utime_ = frame.utime;
}

void ExtrinsicsNode::AddDetection(const Detection& detection, const Pose& T_base_hand) {
  constexpr double kLeastScore = 0.5;
  if (detection.touches_border || detection.verification_score < kLeastScore) return;
  if (config_.setup != HandEyeSetup::kEyeInHand) return;  // The hand carries a target alone.
  const Eigen::Vector3d p_base =
      T_base_hand * calibration_.T_x * detection.T_camera_object.translation();
  auto thing = std::ranges::find_if(things_, [&](const Thing& each) {
    return each.model_id == detection.model_id && (each.p_base - p_base).norm() < kSameThing;
  });
  if (thing == things_.end()) {
    if (things_.size() >= static_cast<size_t>(kMostThings)) return;
    things_.push_back({detection.model_id, p_base, static_cast<int>(things_.size()) + 1});
    thing = std::prev(things_.end());
  }
  // Symmetric objects have no orientation to compare: positions alone.
  constexpr double kAnyRotation = 1.0;  // rad
  DriftView view;
  view.T_base_hand = T_base_hand;
  view.T_camera_target.translation() = detection.T_camera_object.translation();
  view.camera_covariance.setZero();
  view.camera_covariance.diagonal() << Eigen::Vector3d::Constant(kAnyRotation),
      Eigen::Vector3d::Constant(config_.detection_sigma * config_.detection_sigma);
  view.reference = thing->reference;
  check_.Add(view);
}

void ExtrinsicsNode::Tick() {
  const int64_t now = bus_.NowUtime();
  if (config_.setup == HandEyeSetup::kEyeToHand && IsDue(&camera_utime_, now, kCameraPeriod)) {
    PublishCamera(config_.T_world_base * calibration_.T_x, now);
  }
  if (IsDue(&result_utime_, now, kSecond)) {
    const handeye_result_t result = HandEyeToMessage(calibration_, result_seq_++, "");
    if (Result<void> sent = bus_.Publish("HANDEYE_RESULT", result); !sent) {
      Report(sent.error().message);
    }
  }
  if (checked_utime_ != 0 && IsDue(&check_utime_, now, kSecond)) PublishCheck();
}

void ExtrinsicsNode::PublishCheck() {
  const std::optional<DriftReport> before = std::exchange(report_, check_.Report());
  if ((!before || before->state != report_->state) &&
      report_->state != DriftReport::State::kUnknown) {
    std::fprintf(stderr, "hand-eye check: %s\n", report_->reason.c_str());
  }
  const handeye_check_t message = DriftToMessage(
      *report_, calibration_, saw_target_ ? "target" : "detections", checked_utime_, check_seq_++);
  const Result<void> sent = bus_.Publish("HANDEYE_CHECK", message);
  Report(sent ? problem_ : sent.error().message);
}

Result<std::unique_ptr<Node>> MakeExtrinsicsNode(Bus& bus,
                                                 ConfigReader& config,
                                                 const ProcessOptions& /*options*/) {
  const Result<ExtrinsicsConfig> read = ReadExtrinsicsConfig(config);
  IgnoreTablesOfOthers(config);
  if (Result<void> sound = config.Finish(); !sound) return sound.error();
  if (!read) return read.error();
  const Result<HandEyeFile> calibration = ReadHandEyeFile(read->calibration);
  if (!calibration) {
    return Error{calibration.error().code,
                 calibration.error().message + "; vantage-handeye makes one"};
  }
  Result<std::unique_ptr<ExtrinsicsNode>> node = ExtrinsicsNode::Create(bus, *read, *calibration);
  if (!node) return node.error();
  return std::unique_ptr<Node>(std::move(node).value());
}

}  // namespace vantage
