#include "tools/viewer/viewer_state.h"

#include <algorithm>
#include <utility>

#include "bus/conversions.h"
#include "bus/message_check.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/camera_info_t.hpp"
#include "vantage/camera_status_v2_t.hpp"
#include "vantage/process_status_t.hpp"

namespace vantage {
namespace {

constexpr size_t kMaxRecent = 32;                 // Sets of detections.
constexpr size_t kMaxHistogramCells = 8'000'000;  // Of all objects together.

// "CAMERA_" NAME suffix: the name; empty when the channel is none of these.
std::string NameBetween(const std::string& channel, const std::string& suffix) {
  constexpr size_t kPrefix = 7;
  if (!channel.ends_with(suffix) || channel.size() <= kPrefix + suffix.size()) return {};
  return channel.substr(kPrefix, channel.size() - kPrefix - suffix.size());
}

std::string CameraStateName(int state) {
  switch (state) {
    case camera_status_v2_t::SEARCHING:
      return "searching";
    case camera_status_v2_t::OPENING:
      return "opening";
    case camera_status_v2_t::STREAMING:
      return "streaming";
    case camera_status_v2_t::STALLED:
      return "stalled";
    case camera_status_v2_t::LOST:
      return "lost";
    default:
      return "unknown";
  }
}

// The nearest peak to a detection, and how far it is.
void Compare(const ShownObject& object, StepEntry* entry) {
  const Eigen::Quaterniond q(entry->detection->linear());
  for (size_t i = 0; i < object.peaks.size(); ++i) {
    const double angle = GeodesicAngle(q, object.peaks[i].q_world_object);
    if (i > 0 && angle >= entry->angle) continue;
    entry->angle = angle;
    entry->nearest_peak = i;
  }
  entry->distance = (entry->detection->translation() - object.position).norm();
}

}  // namespace

template <class Message>
std::optional<Message> ViewerState::Take(const std::string& channel,
                                         std::span<const std::byte> bytes) {
  Result<Message> message = DecodeChecked<Message>(bytes);
  if (!message) {
    ++num_refused_;
    return std::nullopt;
  }
  ++num_used_;
  if constexpr (requires { message->seq; }) {
    std::string sender = channel;
    if constexpr (requires { message->name; }) {
      sender += '/';
      sender += message->name;
    }
    num_lost_ += sequence_.Add(sender, message->seq, 0);
  }
  return std::move(message).value();
}

void ViewerState::Apply(const std::string& channel,
                        int64_t utime,
                        std::span<const std::byte> bytes) {
  utime_ = utime;
  if (channel.starts_with("CAMERA_")) {
    OnCameraChannel(channel, bytes);
  } else if (channel.starts_with("DETECTIONS_")) {
    OnDetections(channel, bytes);
  } else if (channel == "OBJECTS") {
    OnObjects(bytes);
  } else if (channel == "ORIENTATION_HISTOGRAM") {
    OnHistogram(bytes);
  } else if (channel == "NEXT_VIEW") {
    OnNextView(bytes);
  } else if (channel == "ARM_STATUS") {
    OnArm(bytes);
  } else if (channel == "PROCESS_STATUS") {
    OnProcess(bytes);
  }
}

std::shared_ptr<const orientation_histogram_t> ViewerState::histogram(int32_t instance) const {
  const auto found = histograms_.find(instance);
  return found == histograms_.end() ? nullptr : found->second;
}

void ViewerState::OnObjects(std::span<const std::byte> bytes) {
  const auto message = Take<object_estimates_v3_t>("OBJECTS", bytes);
  if (!message) return;
  const int previous = objects_.num_viewpoints;
  objects_ = ObjectsFromMessage(*message);
  std::erase_if(histograms_,
                [&](const auto& entry) { return objects_.Find(entry.first) == nullptr; });
  if (objects_.num_viewpoints < previous) steps_.clear();  // Fusion was started anew.
  if (objects_.num_viewpoints == 0) return;
  AddStep(objects_.num_viewpoints);
  ShownStep& step = steps_.back();
  step.utime = objects_.utime;
  for (const object_estimate_v3_t& each : message->objects) {
    const ShownObject* object = objects_.Find(each.instance_id);
    if (object == nullptr) continue;
    StepEntry entry;
    entry.model_id = object->model_id;
    for (const ShownPeak& peak : object->peaks) entry.peak_weights.push_back(peak.weight);
    for (const detection_source_t& source : each.sources) {
      if (source.viewpoint != step.viewpoint) continue;
      ++entry.num_detections;
      for (const ShownDetections& set : recent_) {
        if (set.channel != source.channel || set.seq != source.seq || source.index < 0 ||
            static_cast<size_t>(source.index) >= set.detections.size()) {
          continue;
        }
        const ShownDetection& detection = set.detections[static_cast<size_t>(source.index)];
        step.T_world_camera = set.T_world_camera;
        entry.detection = detection.T_world_object;
        entry.score = detection.score;
      }
    }
    if (entry.detection) Compare(*object, &entry);
    step.objects[object->instance] = std::move(entry);
  }
}

void ViewerState::AddStep(int32_t num_viewpoints) {
  if (!steps_.empty() && steps_.back().viewpoint == num_viewpoints - 1) return;
  if (steps_.size() >= kMaxSteps) steps_.erase(steps_.begin());
  steps_.emplace_back();
  steps_.back().viewpoint = num_viewpoints - 1;
  for (const ShownDetections& set : recent_) {
    if (set.utime == objects_.utime) steps_.back().T_world_camera = set.T_world_camera;
  }
}

void ViewerState::OnDetections(const std::string& channel, std::span<const std::byte> bytes) {
  const auto message = Take<detections_v2_t>(channel, bytes);
  if (!message) return;
  std::optional<ShownDetections> shown = ShownFromMessage(*message, channel);
  if (!shown) {
    ++num_refused_;
    return;
  }
  // An estimator that starts again counts anew: of two sets of a number the newer one is meant.
  std::erase_if(recent_, [&](const ShownDetections& set) {
    return set.channel == shown->channel && set.seq == shown->seq;
  });
  detections_ = *shown;
  recent_.push_back(std::move(*shown));
  if (recent_.size() > kMaxRecent) recent_.pop_front();
}

void ViewerState::OnHistogram(std::span<const std::byte> bytes) {
  auto message = Take<orientation_histogram_t>("ORIENTATION_HISTOGRAM", bytes);
  if (!message) return;
  const int32_t instance = message->instance_id;
  histograms_.erase(instance);
  size_t num_cells = message->cell.size();
  for (const auto& [other, histogram] : histograms_) num_cells += histogram->cell.size();
  if (num_cells > kMaxHistogramCells || histograms_.size() >= kMaxObjects) {
    ++num_refused_;
    return;
  }
  histograms_[instance] =
      std::make_shared<const orientation_histogram_t>(std::move(message).value());
}

void ViewerState::OnNextView(std::span<const std::byte> bytes) {
  if (const auto message = Take<next_view_t>("NEXT_VIEW", bytes)) plan_ = PlanFromMessage(*message);
}

void ViewerState::OnArm(std::span<const std::byte> bytes) {
  const auto message = Take<arm_status_t>("ARM_STATUS", bytes);
  if (!message) return;
  arm_state_ = message->state == arm_status_t::RESTING  ? "resting"
               : message->state == arm_status_t::MOVING ? "moving"
                                                        : "refused: " + message->reason;
}

void ViewerState::OnProcess(std::span<const std::byte> bytes) {
  const auto message = Take<process_status_t>("PROCESS_STATUS", bytes);
  if (!message) return;
  if (message->state == "ok") {
    processes_.erase(message->name);
  } else if (processes_.size() < kMaxProcesses || processes_.contains(message->name)) {
    processes_[message->name] = message->state;
  }
}

ShownCamera* ViewerState::CameraNamed(const std::string& name) {
  if (cameras_.size() >= kMaxCameras && !cameras_.contains(name)) return nullptr;
  return &cameras_[name];
}

void ViewerState::OnCameraChannel(const std::string& channel, std::span<const std::byte> bytes) {
  if (const std::string name = NameBetween(channel, "_TO_WORLD"); !name.empty()) {
    OnPose(name, bytes);
  } else if (const std::string info_name = NameBetween(channel, "_INFO"); !info_name.empty()) {
    const auto message = Take<camera_info_t>(channel, bytes);
    ShownCamera* camera = message ? CameraNamed(info_name) : nullptr;
    if (camera == nullptr) return;
    const Result<CameraModel> model = CameraFromMessage(*message);
    if (model) {
      camera->model = *model;
    } else {
      ++num_refused_;
    }
  } else if (const std::string status_name = NameBetween(channel, "_STATUS");
             !status_name.empty()) {
    const auto message = Take<camera_status_v2_t>(channel, bytes);
    ShownCamera* camera = message ? CameraNamed(status_name) : nullptr;
    if (camera != nullptr) camera->state = CameraStateName(message->state);
  } else if (!channel.ends_with("_COMMAND")) {
    OnImages(NameBetween(channel, ""), bytes);
  }
}

}  // namespace vantage
