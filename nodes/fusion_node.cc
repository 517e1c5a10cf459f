#include "nodes/fusion_node.h"

#include <chrono>
#include <cstdio>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bus/conversions.h"
#include "common/check.h"
#include "common/format.h"
#include "common/time_range.h"
#include "nodes/fusion_messages.h"
#include "nodes/fusion_state_file.h"
#include "nodes/object_refinement.h"
#include "planner/circle_view.h"
#include "planner/confusion_heuristic.h"
#include "planner/farthest_view.h"
#include "planner/information_gain.h"
#include "planner/random_view.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/camera_info_t.hpp"
#include "vantage/detections_v2_t.hpp"
#include "vantage/images_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kRepeatInterval = 1'000'000;   // us
constexpr size_t kImageQueueBytes = 16U << 20U;  // Some frames that come while views are chosen.

ViewCriterion MakeCriterion(const FusionConfig& config) {
  if (config.criterion == "farthest") return FarthestView();
  if (config.criterion == "circle") return CircleView();
  if (config.criterion == "random") return RandomView(config.criterion_seed);
  if (config.criterion == "information_gain") return InformationGainView();
  VANTAGE_CHECK(config.criterion == "confusion_heuristic", config.criterion);
  std::map<std::string, const ConfusionModel*> models;
  for (const auto& [id, model] : config.models) {
    if (model.confusion != nullptr) models[id] = model.confusion.get();
  }
  return ConfusionHeuristicView(models);
}

class FusionNode : public Node {
 public:
  FusionNode(Bus& bus, const FusionConfig& config)
      : bus_(bus),
        config_(config),
        grid_(config.k),
        tracker_(grid_, config.tracker, config.models),
        views_(config.views, MakeCriterion(config)) {
    if (!config.refinement.camera.empty()) {
      refinement_.emplace(config.refinement, config.refined_models);
    }
    for (const auto& [model, why] : config.refused_tables) {
      std::string note = why;
      note += "; its detections are weighed by confidence alone";
      Report("table of " + model, Error{ErrorCode::kInvalidArgument, note});
    }
  }

  Result<void> Start(bool fresh) {
    if (Result<void> loaded = LoadState(fresh); !loaded) return loaded;
    if (Result<void> subscribed = Subscribe("DETECTIONS_.*", &FusionNode::OnDetections);
        !subscribed) {
      return subscribed;
    }
    if (Result<void> subscribed = Subscribe("ARM_STATUS", &FusionNode::OnArmStatus); !subscribed) {
      return subscribed;
    }
    if (Result<void> subscribed = Subscribe("CAMERA_.*_TO_WORLD", &FusionNode::OnCameraPose);
        !subscribed) {
      return subscribed;
    }
    if (!refinement_) return {};
    const std::string camera = "CAMERA_" + config_.refinement.camera;
    if (Result<void> subscribed = Subscribe(camera + "_INFO", &FusionNode::OnCameraInfo);
        !subscribed) {
      return subscribed;
    }
    return bus_.Subscribe<images_t>(
        camera,
        {SubscribeOptions::Keep::kAll, kImageQueueBytes},
        [this](const Envelope&, const images_t& message) { refinement_->OnImages(message); });
  }

 private:
  template <class Message>
  Result<void> Subscribe(const std::string& channel,
                         void (FusionNode::*handler)(const std::string&, const Message&)) {
    return bus_.Subscribe<Message>(
        channel, {}, [this, handler](const Envelope& envelope, const Message& message) {
          (this->*handler)(envelope.channel, message);
        });
  }

  void OnDetections(const std::string& channel, const detections_v2_t& message) {
    const Result<DetectionSet> set = DetectionsFromMessage(message, channel);
    if (!set) return ReportDropped(set.error().message);
    const auto start = std::chrono::steady_clock::now();
    const ObjectTracker::Update update = tracker_.Add(*set);
    if (update.num_invalid > 0) {
      ReportDropped(Format("%d of %zu detections of %s are of models not in use or explain nothing",
                           update.num_invalid,
                           set->detections.size(),
                           channel.c_str()));
    } else if (update.num_beyond > 0) {
      ReportDropped(Format("%s shows more than %zu viewpoints or %zu objects",
                           channel.c_str(),
                           ObjectTracker::kMostViewpoints,
                           ObjectTracker::kMostInstances));
    } else {
      Report(kInput, {});
    }
    if (!update.used) return RepeatWhenDue(set->utime);
    utime_ = set->utime;
    const std::vector<ObjectEstimate> objects = tracker_.Estimates();
    bus_.RecordStage(
        "fuse", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    if (refinement_ && update.changed) Refine(*set, objects);

    const bool decided = views_.OnSet(set->utime,
                                      set->T_world_camera,
                                      update.viewpoint,
                                      tracker_.state().viewpoints,
                                      Planned(objects));
    // Saved before it is told: what others have heard is never forgotten.
    if (update.changed || decided) SaveState();
    PublishObjects(objects);
    if (decided) {
      PublishNextView(set->utime);
    } else {
      RepeatWhenDue(set->utime);
    }
  }

  void OnArmStatus(const std::string& channel, const arm_status_t& message) {
    if (!IsPlausible(channel, message.utime)) return;
    if (message.state == arm_status_t::RESTING) {
      views_.OnArrived(message.view_seq, message.utime);
    } else if (message.state == arm_status_t::REFUSED) {
      const std::vector<ObjectEstimate> objects = tracker_.Estimates();
      if (views_.OnRefused(
              message.view_seq, message.reason, tracker_.state().viewpoints, Planned(objects))) {
        SaveState();
        if (views_.finished()) PublishObjects(objects);
        PublishNextView(message.utime);
      }
    }
    RepeatWhenDue(message.utime);
  }

  void OnCameraInfo(const std::string& channel, const camera_info_t& message) {
    const Result<CameraModel> camera = CameraFromMessage(message);
    Report(channel, camera ? Result<void>() : Result<void>(camera.error()));
    if (camera) refinement_->OnCamera(*camera);
  }

  void Refine(const DetectionSet& set, const std::vector<ObjectEstimate>& objects) {
    const auto start = std::chrono::steady_clock::now();
    Report("depth of " + config_.refinement.camera, refinement_->OnSet(set, objects));
    bus_.RecordStage(
        "refine", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }

  void OnCameraPose(const std::string& channel, const rigid_transform_t& message) {
    if (IsPlausible(channel, message.utime)) RepeatWhenDue(message.utime);
  }

  // What the planner may know of the objects. Refers to `objects`.
  [[nodiscard]] std::vector<PlannedObject> Planned(std::span<const ObjectEstimate> objects) const {
    std::vector<PlannedObject> planned = PlanObjects(objects);
    for (size_t i = 0; i < planned.size(); ++i) {
      const PlannedShape& shape = config_.shapes.at(planned[i].model_id);
      planned[i].radius = shape.radius;
      planned[i].mesh = &shape.mesh;
      planned[i].confusion = config_.models.at(planned[i].model_id).confusion.get();
      planned[i].belief = objects[i].belief;
    }
    return planned;
  }

  // Tells the last decision again, a second after it was told last, or when the clock was set back.
  void RepeatWhenDue(int64_t utime) {
    if (restored_) {
      restored_ = false;
      PublishObjects(tracker_.Estimates());
      PublishNextView(utime);
    } else if (views_.decision() >= 0 && (utime - last_told_utime_ >= kRepeatInterval ||
                                          last_told_utime_ - utime >= kRepeatInterval)) {
      PublishNextView(utime);
    }
  }

  void PublishObjects(const std::vector<ObjectEstimate>& objects) {
    restored_ = false;
    object_estimates_v3_t message = ObjectsToMessage(objects);
    if (refinement_) {
      for (object_estimate_v3_t& object : message.objects) {
        const auto refined = refinement_->refined().find(object.instance_id);
        if (refined != refinement_->refined().end()) AddRefinement(refined->second, &object);
      }
    }
    message.utime = utime_;
    message.seq = objects_seq_++;
    message.num_viewpoints = static_cast<int32_t>(tracker_.state().viewpoints.size());
    message.finished = views_.finished() ? 1 : 0;
    Publish("OBJECTS", message);
    for (const ObjectEstimate& object : objects) {
      orientation_histogram_t histogram = HistogramToMessage(object);
      histogram.utime = utime_;
      histogram.seq = histogram_seq_++;
      Publish("ORIENTATION_HISTOGRAM", histogram);
    }
  }

  void PublishNextView(int64_t now_utime) {
    if (views_.decision() < 0) return;
    last_told_utime_ = now_utime;
    next_view_t message = NextViewToMessage(views_.next_view());
    message.utime = utime_;
    message.seq = views_.decision();
    Publish("NEXT_VIEW", message);
  }

  Result<void> LoadState(bool fresh) {
    if (config_.state_file.empty()) return {};
    if (Result<void> ready = PrepareStateFile(config_.state_file); !ready) return ready;
    std::error_code error;
    if (fresh) std::filesystem::remove(config_.state_file, error);
    Result<std::optional<FusionState>> state = LoadFusionState(config_.state_file, config_.setup);
    if (state.ok() && !state->has_value()) return {};
    Result<void> restored = state.ok() ? Restore(**state) : Result<void>(state.error());
    if (restored) return {};
    std::fprintf(stderr,
                 "%s; it was moved to %s.bad and the run starts anew\n",
                 restored.error().message.c_str(),
                 config_.state_file.c_str());
    return MoveAside(config_.state_file);
  }

  Result<void> Restore(const FusionState& state) {
    ObjectTracker tracker = tracker_;  // Nothing was added to it yet; the priors are shared.
    if (Result<void> restored = tracker.Restore(state.tracker); !restored) return restored;
    ViewSequence views(config_.views, MakeCriterion(config_));
    if (Result<void> restored =
            views.Restore(state.views, tracker.state().viewpoints, Planned(tracker.Estimates()));
        !restored) {
      return restored;
    }
    tracker_ = std::move(tracker);
    views_ = std::move(views);
    utime_ = state.utime;
    restored_ = true;
    return {};
  }

  void SaveState() {
    if (config_.state_file.empty()) return;
    Report("state file",
           SaveFusionState({config_.setup, utime_, views_.state(), tracker_.state()},
                           config_.state_file));
  }

  template <class Message>
  void Publish(const std::string& channel, const Message& message) {
    Report(channel, bus_.Publish(channel, message));
  }

  bool IsPlausible(const std::string& channel, int64_t utime) {
    if (IsPlausibleUtime(utime)) return true;
    ReportDropped(Format("%s has the utime %lld us, expected 0 to the year 2200",
                         channel.c_str(),
                         static_cast<long long>(utime)));
    return false;
  }

  void ReportDropped(const std::string& what) {
    ++num_dropped_;
    Report(kInput,
           Error{ErrorCode::kInvalidArgument,
                 Format("%s (%lld times something was dropped)",
                        what.c_str(),
                        static_cast<long long>(num_dropped_))});
  }

  // A trouble is told until the same thing goes well again.
  void Report(const std::string& what, const Result<void>& done) {
    if (done.ok() && problems_.erase(what) == 0) return;
    if (!done) problems_[what] = done.error().message;
    std::string state;
    for (const auto& [each, problem] : problems_) state += (state.empty() ? "" : "; ") + problem;
    bus_.SetState(state.empty() ? "ok" : state);
  }

  static constexpr const char* kInput = "input";

  Bus& bus_;
  const FusionConfig config_;
  const So3Grid grid_;
  ObjectTracker tracker_;
  ViewSequence views_;
  std::optional<ObjectRefinement> refinement_;  // Nothing where no camera is named for it.
  int64_t utime_ = 0;                           // us, of the last image used
  int64_t last_told_utime_ = 0;                 // us, message time at which NEXT_VIEW was sent last
  bool restored_ = false;                       // What was restored has not been told yet.
  int64_t objects_seq_ = 0;
  int64_t histogram_seq_ = 0;
  int64_t num_dropped_ = 0;
  std::map<std::string, std::string> problems_;  // By what is not well: input, a channel, ...
};

}  // namespace

Result<std::unique_ptr<Node>> MakeFusionNode(Bus& bus,
                                             ConfigReader& config,
                                             const ProcessOptions& options) {
  Result<FusionConfig> fusion = ReadFusionConfig(config);
  if (!fusion) return fusion.error();
  return MakeFusionNode(bus, *fusion, options.fresh);
}

Result<std::unique_ptr<Node>> MakeFusionNode(Bus& bus, const FusionConfig& config, bool fresh) {
  if (Result<void> valid = config.tracker.Validate(); !valid) return valid.error();
  if (Result<void> valid = config.views.Validate(); !valid) return valid.error();
  auto node = std::make_unique<FusionNode>(bus, config);
  if (Result<void> started = node->Start(fresh); !started) return started.error();
  return std::unique_ptr<Node>(std::move(node));
}

}  // namespace vantage
