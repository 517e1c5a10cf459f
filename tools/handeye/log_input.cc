#include "tools/handeye/log_input.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/gray_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "common/pose_buffer.h"
#include "common/time_range.h"
#include "perception/model/object_model.h"

namespace vantage {
namespace {

constexpr int64_t kRestWindow = 100'000;        // us, before and after an image
constexpr int64_t kInMotionInterval = 200'000;  // us, from one view to the next
constexpr size_t kMostSamples = 10'000'000;     // Of the hand.
constexpr size_t kMostViews = 500;
constexpr size_t kMostSymmetries = 24;
constexpr double kSameRest = 0.001;          // m; and
constexpr double kSameTurn = 0.2 * kDegree;  // rad, from one rest to the next

// Of the hand and the camera, all over a log.
struct HandOverLog {
  PoseBuffer buffer{PoseBuffer::Parameters{.horizon_us = kLatestUtime}};
  std::vector<HandTrajectory::Sample> samples;
  std::optional<CameraIntrinsics> intrinsics;
  bool is_registered = true;
  std::string damage;
};

Error InLog(const LogSelection& selection, ErrorCode code, const std::string& what) {
  return {code, Format("%s: %s", selection.log.c_str(), what.c_str())};
}

// Its lens may be told: images are published as the device gives them.
std::optional<CameraIntrinsics> IntrinsicsOf(camera_info_t message) {
  CameraIntrinsics intrinsics;
  const std::vector<double> k = message.distortion;
  std::ranges::fill(message.distortion, 0.0);
  const Result<CameraModel> camera = CameraFromMessage(message);
  if (!camera) return std::nullopt;
  intrinsics.camera = *camera;
  const bool finite = std::ranges::all_of(k, [](double each) { return std::abs(each) <= 100.0; });
  if (!finite || (!k.empty() && k.size() != 5)) return std::nullopt;
  if (k.size() == 5) intrinsics.distortion = {k[0], k[1], k[2], k[3], k[4]};
  return intrinsics;
}

Result<HandOverLog> ReadHand(const LogSelection& selection) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(selection.log);
  if (!reader) return reader.error();
  const std::string info = Format("CAMERA_%s_INFO", selection.camera.c_str());
  HandOverLog hand;
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (event->channel == selection.hand_channel) {
      const auto message = DecodeChecked<rigid_transform_t>(event->data);
      if (!message) continue;
      const Result<Pose> pose = PoseFromMessage(*message);
      if (!pose || hand.samples.size() >= kMostSamples) continue;
      hand.samples.push_back({message->utime, *pose});
      hand.buffer.Add(message->utime, *pose);
    } else if (event->channel == info && !hand.intrinsics) {
      const auto message = DecodeChecked<camera_info_t>(event->data);
      if (!message) continue;
      hand.intrinsics = IntrinsicsOf(*message);
      hand.is_registered = message->registered != 0;
    }
  }
  if ((*reader)->damage().any()) hand.damage = (*reader)->damage().Describe();
  if (hand.samples.empty()) {
    return InLog(
        selection,
        ErrorCode::kNotFound,
        Format("no poses of the hand (rigid_transform_t) on channel %s, expected them; see "
               "--hand-channel",
               selection.hand_channel.c_str()));
  }
  return hand;
}

// Says which images make a view: one of each rest, or some of a motion.
class ViewChoice {
 public:
  ViewChoice(const LogSelection& selection, const HandOverLog& hand)
      : in_motion_(selection.in_motion), hand_(hand) {}

  // The hand's pose of an image that may be a view.
  std::optional<Pose> Consider(int64_t utime) const {
    if (num_views_ >= kMostViews) return std::nullopt;
    const std::optional<Pose> pose = hand_.buffer.At(utime);
    if (!pose) return std::nullopt;
    if (in_motion_) {
      if (last_ && std::abs(utime - last_utime_) < kInMotionInterval) return std::nullopt;
      return pose;
    }
    if (!hand_.buffer.RestsAt(utime, kRestWindow)) return std::nullopt;
    if (last_) {
      const Pose moved = last_->inverse() * *pose;
      const double turn =
          GeodesicAngle(Eigen::Quaterniond(moved.linear()), Eigen::Quaterniond::Identity());
      if (moved.translation().norm() < kSameRest && turn < kSameTurn) return std::nullopt;
    }
    return pose;
  }
  void Take(int64_t utime, const Pose& pose) {
    last_ = pose;
    last_utime_ = utime;
    ++num_views_;
  }

 private:
  bool in_motion_;
  const HandOverLog& hand_;
  std::optional<Pose> last_;
  int64_t last_utime_ = 0;
  size_t num_views_ = 0;
};

// The symmetric poses of the model's center.
std::vector<Pose> PosesOf(const Detection& detection, const ObjectModel& model) {
  std::vector<Pose> poses;
  for (const Eigen::Quaterniond& element : model.symmetry.elements) {
    Pose pose = detection.T_camera_object * Eigen::Translation3d(model.center);
    pose.linear() = pose.linear() * element.toRotationMatrix();
    poses.push_back(pose);
  }
  return poses;
}

Result<ObjectModel> LoadTarget(const std::filesystem::path& folder) {
  Result<ObjectModel> model = LoadObjectModel(folder);
  if (!model) return model;
  if (model->symmetry.kind == SymmetryGroup::Kind::kContinuous ||
      model->symmetry.elements.size() > kMostSymmetries) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("model %s is symmetric about an axis, expected an object whose orientation "
                        "a view tells",
                        model->id.c_str())};
  }
  return model;
}

}  // namespace

Result<CalibrationInput> InputFromLogImages(const LogSelection& selection,
                                            const CalibrationTarget& target,
                                            const std::optional<CameraIntrinsics>& intrinsics,
                                            double pixel_sigma) {
  Result<HandOverLog> hand = ReadHand(selection);
  if (!hand) return hand.error();
  if (!intrinsics && !hand->intrinsics) {
    return InLog(selection,
                 ErrorCode::kNotFound,
                 Format("no intrinsics on CAMERA_%s_INFO, expected them, or --intrinsics FILE",
                        selection.camera.c_str()));
  }
  Result<ImageInput> input =
      ImageInput::Make(target, intrinsics ? *intrinsics : *hand->intrinsics, pixel_sigma);
  if (!input) return input.error();
  const std::string channel = Format("CAMERA_%s", selection.camera.c_str());
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(selection.log);
  if (!reader) return reader.error();
  ViewChoice choice(selection, *hand);
  size_t num_images = 0;
  std::string trouble;
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (event->channel != channel) continue;
    const auto message = DecodeChecked<images_t>(event->data);
    if (!message || !IsPlausibleUtime(message->utime)) continue;
    ++num_images;
    const std::optional<Pose> pose = choice.Consider(message->utime);
    if (!pose) continue;
    Result<GrayFrame> frame = GrayFrameFromMessage(*message);
    if (!frame) {
      trouble = frame.error().message;
      continue;
    }
    choice.Take(frame->utime, *pose);
    const NamedImage named{
        Format("image at %.2f s",
               1e-6 * static_cast<double>(frame->utime - hand->samples.front().utime)),
        frame->utime,
        RawFromPose(*pose),
        std::move(frame->image)};
    if (Result<void> added = input->Add(named); !added) return added.error();
  }
  if (num_images == 0 || (!trouble.empty() && !input->HasImages())) {
    return InLog(selection,
                 ErrorCode::kNotFound,
                 num_images == 0 ? Format("no images on channel %s", channel.c_str()) : trouble);
  }
  if (!input->HasImages()) {
    return InLog(
        selection,
        ErrorCode::kNotFound,
        Format("the hand rests at none of %zu images, expected it to stop for 0.2 s or more "
               "where views are to be taken",
               num_images));
  }
  Result<CalibrationInput> made = input->Finish();
  if (!made) return InLog(selection, made.error().code, made.error().message);
  made->trajectory = HandTrajectory(std::move(hand->samples));
  if (!hand->damage.empty()) made->notes.push_back("the log is damaged: " + hand->damage);
  if (!intrinsics && !hand->is_registered) {
    made->notes.push_back(Format(
        "CAMERA_%s_INFO is of the depth camera, which does not see with the eyes of the color one; "
        "give the color camera's --intrinsics",
        selection.camera.c_str()));
  }
  return made;
}

Result<CalibrationInput> InputFromDetections(const LogSelection& selection,
                                             const std::string& detections_channel,
                                             const std::filesystem::path& model_folder) {
  const Result<ObjectModel> model = LoadTarget(model_folder);
  if (!model) return model.error();
  Result<HandOverLog> hand = ReadHand(selection);
  if (!hand) return hand.error();
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(selection.log);
  if (!reader) return reader.error();
  CalibrationInput input;
  ViewChoice choice(selection, *hand);
  size_t num_sets = 0;
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (event->channel != detections_channel) continue;
    const auto message = DecodeChecked<detections_v2_t>(event->data);
    if (!message) continue;
    const Result<DetectionSet> set = DetectionsFromMessage(*message, event->channel);
    if (!set || set->camera != selection.camera) continue;
    ++num_sets;
    const std::optional<Pose> pose = choice.Consider(set->utime);
    if (!pose) continue;
    const Detection* best = nullptr;
    for (const Detection& each : set->detections) {
      if (each.model_id != model->id || each.touches_border) continue;
      if (best == nullptr || each.verification_score > best->verification_score) best = &each;
    }
    if (best == nullptr) continue;
    choice.Take(set->utime, *pose);
    const std::vector<Pose> poses = PosesOf(*best, *model);
    PoseView view{
        .name = Format("image at %.2f s",
                       1e-6 * static_cast<double>(set->utime - hand->samples.front().utime)),
        .utime = set->utime,
        .T_base_hand = *pose,
        .T_camera_target = poses.front(),
        .other_T_camera_target = {poses.begin() + 1, poses.end()}};
    if ((best->covariance.diagonal().array() > 0.0).all()) view.covariance = best->covariance;
    input.raw.push_back({view.name, view.utime, RawFromPose(*pose), RawFromPose(poses.front())});
    input.poses.push_back(std::move(view));
  }
  if (input.poses.empty()) {
    return InLog(selection,
                 ErrorCode::kNotFound,
                 Format("none of %zu messages of camera %s on channel %s holds a detection of %s "
                        "where the hand rests",
                        num_sets,
                        selection.camera.c_str(),
                        detections_channel.c_str(),
                        model->id.c_str()));
  }
  // With other poses by symmetry the poses as they are need not agree: they are measured.
  input.source = InputSource::kPosesAndImages;
  input.intrinsics = hand->intrinsics;
  input.trajectory = HandTrajectory(std::move(hand->samples));
  if (!hand->damage.empty()) input.notes.push_back("the log is damaged: " + hand->damage);
  return input;
}

}  // namespace vantage
