#include "tools/support/recorded_run.h"

#include <algorithm>
#include <utility>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "perception/model/object_model.h"
#include "vantage/camera_info_t.hpp"

namespace vantage {
namespace {

// Follows a log's messages in their order.
class RunReader {
 public:
  explicit RunReader(std::string camera) : camera_channel_("CAMERA_" + std::move(camera)) {}

  void Read(const LogEvent& event) {
    if (event.channel == "OBJECTS") {
      auto message = DecodeChecked<object_estimates_v3_t>(event.data);
      if (message) OnObjects(std::move(message).value());
    } else if (event.channel.starts_with("DETECTIONS_")) {
      const auto message = DecodeChecked<detections_v2_t>(event.data);
      if (!message) return;
      const Result<DetectionSet> set = DetectionsFromMessage(*message, event.channel);
      if (set) latest_sets_[{event.channel, set->seq}] = *set;
    } else if (event.channel == "ORIENTATION_HISTOGRAM") {
      auto message = DecodeChecked<orientation_histogram_t>(event.data);
      if (message && !run_.views.empty()) {
        run_.views.back().histograms[message->instance_id] = std::move(message).value();
      }
    } else if (event.channel == "NEXT_VIEW") {
      auto message = DecodeChecked<next_view_t>(event.data);
      if (message && !run_.views.empty()) run_.views.back().next_view = std::move(message).value();
    } else if (event.channel == camera_channel_ + "_INFO") {
      const auto message = DecodeChecked<camera_info_t>(event.data);
      if (!message) return;
      if (const Result<CameraModel> camera = CameraFromMessage(*message)) run_.camera = *camera;
    }
  }

  RecordedRun Finish() && { return std::move(run_); }

 private:
  void OnObjects(object_estimates_v3_t message) {
    // Ids end up in pages and files: only such as models have.
    std::erase_if(message.objects, [](const object_estimate_v3_t& object) {
      return !CheckModelId(object.model_id).ok();
    });
    message.num_objects = static_cast<int32_t>(message.objects.size());
    const auto num_views = static_cast<size_t>(std::clamp(message.num_viewpoints, 0, 100'000));
    if (num_views < run_.views.size()) {  // Fusion was started anew.
      run_.views.clear();
      run_.finished = false;
    }
    run_.finished = run_.finished || message.finished != 0;
    if (num_views == 0) return;
    run_.views.resize(num_views);
    RunView& view = run_.views.back();
    view.objects = std::move(message);
    if (view.utime == 0) PlaceView(&view);
    for (const object_estimate_v3_t& object : view.objects.objects) {
      for (const detection_source_t& source : object.sources) {
        if (source.viewpoint == static_cast<int32_t>(num_views) - 1) {
          TakeDetection(object.instance_id, source, &view);
        }
      }
    }
  }

  // A view in which nothing was found has a place and an image too.
  void PlaceView(RunView* view) const {
    for (const auto& [key, set] : latest_sets_) {
      if (set.utime != view->objects.utime) continue;
      view->utime = set.utime;
      view->T_world_camera = set.T_world_camera;
    }
  }

  void TakeDetection(int32_t instance, const detection_source_t& source, RunView* view) {
    const auto set = latest_sets_.find({source.channel, source.seq});
    if (set == latest_sets_.end() || source.index < 0 ||
        static_cast<size_t>(source.index) >= set->second.detections.size()) {
      return;
    }
    view->utime = set->second.utime;
    view->T_world_camera = set->second.T_world_camera;
    view->detections[instance] =
        set->second.T_world_camera *
        set->second.detections[static_cast<size_t>(source.index)].T_camera_object;
  }

  std::string camera_channel_;
  RecordedRun run_;
  // By channel and seq the latest: an estimator that starts again counts anew.
  std::map<std::pair<std::string, int64_t>, DetectionSet> latest_sets_;
};

Result<void> ReadImages(const std::filesystem::path& log,
                        const std::string& channel,
                        std::vector<RunView>* views) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log);
  if (!reader) return reader.error();
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (event->channel != channel) continue;
    const auto message = DecodeChecked<images_t>(event->data);
    if (!message) continue;
    for (RunView& view : *views) {
      if (view.utime != message->utime || view.depth.width != 0) continue;
      Result<DepthFrame> frame = DepthFrameFromMessage(*message);
      if (frame) view.depth = std::move(frame).value().image;
    }
  }
  return {};
}

}  // namespace

Result<RecordedRun> ReadRun(const std::filesystem::path& log, const std::string& camera) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log);
  if (!reader) return reader.error();
  RunReader run_reader(camera);
  while (const std::optional<LogEvent> event = (*reader)->Next()) run_reader.Read(*event);
  RecordedRun run = std::move(run_reader).Finish();
  if ((*reader)->damage().any()) run.damage = (*reader)->damage().Describe();
  if (run.views.empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("log %s has no OBJECTS with a viewpoint, expected a run of vantage-fusion",
                        log.c_str())};
  }
  if (Result<void> read = ReadImages(log, "CAMERA_" + camera, &run.views); !read) {
    return read.error();
  }
  return run;
}

std::optional<Pose> EstimatedPose(const object_estimate_v3_t& object) {
  if (object.peaks.empty()) return std::nullopt;
  const Result<Pose> pose = PoseFromWire(object.trans, object.peaks.front().quat);
  if (!pose) return std::nullopt;
  return *pose;
}

std::optional<Pose> RefinedPose(const object_estimate_v3_t& object) {
  if (object.refinement != object_estimate_v3_t::REFINED) return std::nullopt;
  const Result<Pose> pose = PoseFromWire(object.refined_trans, object.refined_quat);
  if (!pose) return std::nullopt;
  return *pose;
}

}  // namespace vantage
