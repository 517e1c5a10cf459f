#include "nodes/estimator_node.h"

#include <cctype>
#include <chrono>

#include "bus/conversions.h"
#include "common/format.h"
#include "nodes/ppf_config.h"
#include "nodes/shot_config.h"
#include "vantage/detections_v2_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kLargestDisorder = 200'000;  // us, by which an image may come after later ones

// For the process status alone: never part of what is published.
double SteadySeconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

Result<std::unique_ptr<Node>> MakeNode(Bus& bus,
                                       const EstimatorConfig& config,
                                       const ProcessOptions& options,
                                       Result<std::unique_ptr<PoseEstimator>> estimator) {
  if (!estimator) return estimator.error();
  Result<std::unique_ptr<EstimatorNode>> node = EstimatorNode::Create(
      bus, config, options.name, EstimateBy(std::move(estimator).value(), config.seed));
  if (!node) return node.error();
  return std::unique_ptr<Node>(std::move(node).value());
}

}  // namespace

std::string DetectionsChannel(const std::string& process_name) {
  std::string channel = "DETECTIONS_";
  for (const char c : process_name) {
    channel += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return channel;
}

EstimateFunction EstimateBy(std::shared_ptr<PoseEstimator> estimator, uint64_t seed) {
  return [ estimator = std::move(estimator), seed ](
             const DepthFrame& frame, const CameraModel& camera, StageTimes* times) -> const auto& {
    // Of the image alone, so that no image's result depends on those before.
    Rng rng(seed, static_cast<uint64_t>(frame.utime));
    return estimator->Estimate(frame.image, camera, rng, times);
  };
}

Result<std::unique_ptr<EstimatorNode>> EstimatorNode::Create(Bus& bus,
                                                             const EstimatorConfig& config,
                                                             const std::string& process_name,
                                                             EstimateFunction estimate) {
  std::unique_ptr<EstimatorNode> node(
      new EstimatorNode(bus, config, process_name, std::move(estimate)));
  if (Result<void> subscribed = node->Subscribe(); !subscribed) return subscribed.error();
  return node;
}

EstimatorNode::EstimatorNode(Bus& bus,
                             const EstimatorConfig& config,
                             const std::string& process_name,
                             EstimateFunction estimate)
    : bus_(bus),
      config_(config),
      name_(process_name),
      channel_("CAMERA_" + config.camera),
      estimate_(std::move(estimate)) {}

Result<void> EstimatorNode::Subscribe() {
  const SubscribeOptions all{SubscribeOptions::Keep::kAll};
  const SubscribeOptions latest{SubscribeOptions::Keep::kLatest};
  Result<void> subscribed = bus_.Subscribe<camera_info_t>(
      channel_ + "_INFO", latest, [this](const Envelope&, const camera_info_t& message) {
        OnInfo(message);
      });
  if (!subscribed) return subscribed;
  subscribed = bus_.Subscribe<rigid_transform_t>(
      channel_ + "_TO_WORLD", all, [this](const Envelope&, const rigid_transform_t& message) {
        OnPose(message);
      });
  if (!subscribed) return subscribed;
  return bus_.Subscribe<images_t>(
      channel_, latest, [this](const Envelope& envelope, const images_t& message) {
        OnImages(envelope, message);
      });
}

void EstimatorNode::Report(const std::string& problem) {
  if (problem == state_) return;
  state_ = problem;
  bus_.SetState(problem);
}

void EstimatorNode::OnInfo(const camera_info_t& message) {
  const Result<CameraModel> camera = CameraFromMessage(message);
  if (!camera) {
    Report(channel_ + "_INFO: " + camera.error().message);
    return;
  }
  camera_ = *camera;
  ProcessPending();
}

void EstimatorNode::OnPose(const rigid_transform_t& message) {
  const Result<Pose> pose = PoseFromMessage(message);
  if (!pose) {
    Report(channel_ + "_TO_WORLD: " + pose.error().message);
    return;
  }
  if (poses_.Add(message.utime, *pose)) ForgetPass();
  ProcessPending();
}

// The clock was set back, or a log began again: images of the pass before would be taken for ones
// at the times of this pass. What tells first, a pose or an image, makes both forget.
void EstimatorNode::ForgetPass() {
  pending_.clear();
  last_image_utime_.reset();
}

void EstimatorNode::OnImages(const Envelope& envelope, const images_t& message) {
  Result<DepthFrame> frame = DepthFrameFromMessage(message);
  num_passed_over_ += envelope.num_skipped;
  if (!frame) {
    ++num_passed_over_;
    Report(channel_ + ": " + frame.error().message);
    return;
  }
  if (frame->seq >= 0) {
    // images_t is not ours and has its seq in the metadata, where the bus does not look.
    const int64_t lost = image_sequence_.Add(channel_, frame->seq, num_passed_over_);
    if (lost > 0) bus_.RecordLost(channel_, lost);
    num_passed_over_ = 0;
  }
  if (last_image_utime_ && frame->utime < *last_image_utime_ - kLargestDisorder) {
    ForgetPass();
    poses_ = PoseBuffer();
  }
  last_image_utime_ = frame->utime;
  pending_.push_back(std::move(frame).value());
  if (pending_.size() > kMaxPending) {
    pending_.pop_front();
    Report(camera_ ? "images come, but no poses of their time on " + channel_ + "_TO_WORLD"
                   : "images come, but no calibration on " + channel_ + "_INFO");
  }
  ProcessPending();
}

// Whether the camera was at rest is known only when poses of some time after the image are there.
void EstimatorNode::ProcessPending() {
  const std::optional<int64_t> newest = poses_.Newest();
  if (!camera_ || !newest) return;
  const auto window = static_cast<int64_t>(1e6 * config_.rest_window_s);
  std::deque<DepthFrame> waiting;
  std::deque<DepthFrame> images;
  images.swap(pending_);
  for (DepthFrame& frame : images) {
    if (*newest < frame.utime + window) {
      waiting.push_back(std::move(frame));
      continue;
    }
    if (!poses_.RestsAt(frame.utime, window)) continue;
    const std::optional<Pose> T_world_camera = poses_.At(frame.utime);
    if (T_world_camera) Process(frame, *T_world_camera);
  }
  pending_ = std::move(waiting);
}

void EstimatorNode::Process(const DepthFrame& frame, const Pose& T_world_camera) {
  if (frame.image.width != camera_->width || frame.image.height != camera_->height) {
    Report(Format("%s has %d x %d px, expected the %d x %d px of %s_INFO",
                  channel_.c_str(),
                  frame.image.width,
                  frame.image.height,
                  camera_->width,
                  camera_->height,
                  channel_.c_str()));
    return;
  }
  const int64_t start = bus_.NowUtime();
  StageTimes times;
  times.clock = SteadySeconds;
  const double begin = SteadySeconds();
  const PoseEstimator::Output& output = estimate_(frame, *camera_, &times);

  DetectionSet set;
  set.utime = frame.utime;
  set.seq = seq_++;
  set.camera = config_.camera;
  set.image_seq = frame.seq;
  set.estimator = name_;
  set.T_world_camera = T_world_camera;
  // 0 over a log, so that every rerun writes the same bytes.
  set.compute_time = 1e-6 * static_cast<double>(bus_.NowUtime() - start);
  set.num_clusters = output.num_clusters;
  set.detections = output.detections;
  const Result<void> sent = bus_.Publish(DetectionsChannel(name_), DetectionsToMessage(set));
  Report(sent ? "ok" : sent.error().message);

  bus_.RecordStage("segmentation", times.segmentation);
  bus_.RecordStage("normals", times.normals);
  bus_.RecordStage("proposal", times.proposal);
  bus_.RecordStage("verification", times.verification);
  bus_.RecordStage("refinement", times.refinement);
  bus_.RecordStage("total", SteadySeconds() - begin);
}

Result<std::unique_ptr<Node>> MakePpfNode(Bus& bus,
                                          ConfigReader& config,
                                          const ProcessOptions& options) {
  const Result<PpfConfig> read = ReadPpfConfig(config);
  if (!read) return read.error();
  Result<std::vector<PpfModel>> models = LoadPpfModels(read->models, read->estimator.table);
  if (!models) return models.error();
  return MakeNode(
      bus, *read, options, CreatePpfEstimator(std::move(models).value(), read->estimator));
}

Result<std::unique_ptr<Node>> MakeShotNode(Bus& bus,
                                           ConfigReader& config,
                                           const ProcessOptions& options) {
  const Result<ShotConfig> read = ReadShotConfig(config);
  if (!read) return read.error();
  Result<std::vector<ObjectModel>> models = LoadModels(read->models);
  if (!models) return models.error();
  return MakeNode(
      bus, *read, options, CreateShotEstimator(std::move(models).value(), read->estimator));
}

}  // namespace vantage
