#include "nodes/sim_arm_node.h"

#include <chrono>
#include <span>
#include <utility>

#include "bus/conversions.h"
#include "common/format.h"
#include "nodes/sim_config.h"
#include "vantage/arm_status_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kPosePeriod = 10'000;     // us
constexpr int64_t kStatusPeriod = 100'000;  // us

/// The next multiple-of-a-period time after `now`, keeping to the rhythm of `last` where that is
/// possible: a late call must not make the rate sink.
int64_t NextTime(int64_t last, int64_t now, int64_t period) {
  const int64_t next = last + period;
  return next > now && next <= now + period ? next : now + period;
}

bool SamePose(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm() < 1e-9 &&
         GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) < 1e-9;
}

/// The selected candidate's pose; an error when there is no such candidate or no such pose.
Result<Pose> SelectedPose(const next_view_t& view) {
  if (view.selected < 0 || view.selected >= view.num_candidates) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("candidate %d is selected of %d", view.selected, view.num_candidates)};
  }
  const view_candidate_t& candidate = view.candidates[static_cast<size_t>(view.selected)];
  return PoseFromWire(std::span<const double, 3>(candidate.trans),
                      std::span<const double, 4>(candidate.quat));
}

}  // namespace

SimArmNode::SimArmNode(Bus& bus,
                       const SimArmParameters& parameters,
                       const std::optional<SimHandParameters>& hand,
                       const std::string& camera_name,
                       SteadyClock steady_us)
    : bus_(bus),
      arm_(parameters),
      hand_(hand ? std::optional<SimHand>(*hand) : std::nullopt),
      camera_name_(camera_name),
      pose_channel_(SimCameraPoseChannel(camera_name, hand.has_value())),
      steady_us_(std::move(steady_us)),
      start_us_(steady_us_()),
      next_pose_us_(start_us_),
      next_status_us_(start_us_) {}

Result<void> SimArmNode::Subscribe() {
  return bus_.Subscribe<next_view_t>(
      hand_ ? "NEXT_HAND_POSE" : "NEXT_VIEW", {}, [this](const Envelope&, const next_view_t& view) {
        HandleNextView(view);
      });
}

double SimArmNode::Seconds(int64_t steady_us) const {
  return 1e-6 * static_cast<double>(steady_us - start_us_);
}

void SimArmNode::HandleNextView(const next_view_t& view) {
  if (view.selected == -1) return;  // Stay.
  const int64_t now = steady_us_();
  const Result<Pose> pose = SelectedPose(view);
  if (!pose) {
    refusal_ = pose.error().message;
    view_pose_.reset();
  } else {
    // A planner repeats its decision; one that was started anew counts from 0 again, and then the
    // pose tells that it is another decision.
    if (view.seq == view_seq_ && view_pose_ && SamePose(*view_pose_, *pose)) return;
    const Result<void> accepted = arm_.MoveTo(hand_ ? hand_->CameraAt(*pose) : *pose, Seconds(now));
    refusal_ = accepted ? std::string() : accepted.error().message;
    view_pose_ = *pose;
  }
  view_seq_ = view.seq;
  PublishStatus(now);
}

void SimArmNode::Poll() {
  const int64_t now = steady_us_();
  if (now >= next_pose_us_) PublishPoses(now);
  const bool moving = arm_.Remaining(Seconds(now)) > 0.0;
  const bool changed = moving != (last_state_ == arm_status_t::MOVING);
  if (changed || now >= next_status_us_) PublishStatus(now);
}

void SimArmNode::PublishPoses(int64_t now) {
  next_pose_us_ = NextTime(next_pose_us_, now, kPosePeriod);
  const Pose T_world_camera = arm_.PoseAt(Seconds(now));
  const int64_t utime = bus_.NowUtime();
  Result<void> sent = bus_.Publish(pose_channel_, PoseToMessage(T_world_camera, utime));
  if (sent && hand_) {
    sent = bus_.Publish("HAND_TO_BASE", PoseToMessage(hand_->Believed(T_world_camera), utime));
  }
  bus_.SetState(sent ? "ok" : sent.error().message);
}

void SimArmNode::PublishStatus(int64_t now) {
  next_status_us_ = NextTime(next_status_us_, now, kStatusPeriod);
  arm_status_t status{};
  status.utime = bus_.NowUtime();
  status.seq = status_seq_++;
  status.name = camera_name_;
  status.remaining = arm_.Remaining(Seconds(now));
  status.state = status.remaining > 0.0 ? arm_status_t::MOVING
                 : refusal_.empty()     ? arm_status_t::RESTING
                                        : arm_status_t::REFUSED;
  status.view_seq = view_seq_;
  status.reason = refusal_;
  last_state_ = status.state;
  if (const Result<void> sent = bus_.Publish("ARM_STATUS", status); !sent) {
    bus_.SetState(sent.error().message);
  }
}

Result<std::unique_ptr<Node>> MakeSimArmNode(Bus& bus,
                                             ConfigReader& config,
                                             const ProcessOptions& /*options*/) {
  const Result<SimConfig> sim = ReadSimConfig(config);
  IgnoreTablesOfOthers(config);
  if (Result<void> read = config.Finish(); !read) return read.error();
  if (!sim) return sim.error();
  const auto steady_us = [] {
    return std::chrono::duration_cast<std::chrono::microseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  };
  auto node = std::make_unique<SimArmNode>(bus, sim->arm, sim->hand, sim->camera_name, steady_us);
  if (Result<void> subscribed = node->Subscribe(); !subscribed) return subscribed.error();
  return std::unique_ptr<Node>(std::move(node));
}

}  // namespace vantage
