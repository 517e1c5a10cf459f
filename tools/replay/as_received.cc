#include "tools/replay/as_received.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "bus/message_check.h"
#include "bus/sequence_tracker.h"
#include "bus/wire.h"
#include "common/format.h"
#include "vantage/detections_v2_t.hpp"
#include "vantage/images_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {
namespace {

constexpr const char* kDetections = "DETECTIONS_";

/// images_t.utime, without the images. Nothing: another type.
std::optional<int64_t> ImageUtime(const LogEvent& event) {
  constexpr size_t kHash = sizeof(int64_t);
  const std::span<const std::byte> bytes(event.data);
  if (bytes.size() < 2 * kHash || LoadBigEndian<int64_t>(bytes) != images_t::getHash()) return {};
  return LoadBigEndian<int64_t>(bytes.subspan(kHash));
}

}  // namespace

AsReceived::AsReceived(LogBus* bus, size_t most_bytes) : bus_(*bus), most_bytes_(most_bytes) {
  bus->Watch([this](const LogEvent& event) { OnEvent(event); });
}

void AsReceived::Add(const std::string& name,
                     const std::string& camera,
                     LogBus::Port* port,
                     EstimatorNode* node) {
  Estimator& estimator = estimators_[DetectionsChannel(name)];
  estimator.camera_channel = "CAMERA_" + camera;
  estimator.port = port;
  estimator.node = node;
}

void AsReceived::OnEvent(const LogEvent& event) {
  if (!start_utime_) start_utime_ = event.utime;
  if (const auto found = estimators_.find(event.channel); found != estimators_.end()) {
    return OnDetections(event, &found->second);
  }
  const bool is_image = std::ranges::any_of(
      estimators_, [&](const auto& each) { return each.second.camera_channel == event.channel; });
  if (is_image) return Hold(event);
  OnOthers(event);
}

void AsReceived::Hold(const LogEvent& event) {
  const std::optional<int64_t> utime = ImageUtime(event);
  if (!utime) return;
  held_bytes_ += event.data.size();
  held_.push_back({*utime, arrivals_++, event});
  while (held_bytes_ > most_bytes_ && held_.size() > 1) {
    given_up_utime_[held_.front().event.channel] = held_.front().utime;
    Drop();
  }
}

void AsReceived::Drop() {
  held_bytes_ -= held_.front().event.data.size();
  held_.pop_front();
}

void AsReceived::OnDetections(const LogEvent& event, Estimator* estimator) {
  const Result<detections_v2_t> set = DecodeChecked<detections_v2_t>(event.data);
  if (!set) {
    ++estimator->num_corrupt;
    return;
  }
  Note(set->seq, &counts_[event.channel]);
  // The newest: after a clock was set back, images of the same times came before.
  const auto found = std::find_if(held_.rbegin(), held_.rend(), [&](const Image& image) {
    return image.utime == set->utime && image.event.channel == estimator->camera_channel;
  });
  if (found == held_.rend()) {
    if (estimator->num_absent + estimator->num_given_up == 0) estimator->first_absent = Now();
    const auto given_up = given_up_utime_.find(estimator->camera_channel);
    const bool was_held = given_up != given_up_utime_.end() && set->utime <= given_up->second;
    ++(was_held ? estimator->num_given_up : estimator->num_absent);
    return;
  }
  estimator->last_arrival = found->arrival;
  ++estimator->num_delivered;
  estimator->node->CountFrom(set->seq);
  estimator->port->Deliver(found->event);
  // An estimator takes images in their order: nobody wants those before again.
  int64_t done = std::numeric_limits<int64_t>::max();
  for (const auto& [channel, each] : estimators_) done = std::min(done, each.last_arrival);
  while (!held_.empty() && held_.front().arrival <= done) Drop();
}

void AsReceived::OnOthers(const LogEvent& event) {
  if (event.channel.starts_with(kDetections)) ++others_[event.channel];
  if (event.channel != "OBJECTS") return;
  const Result<object_estimates_v3_t> objects = DecodeChecked<object_estimates_v3_t>(event.data);
  if (!objects) return;
  // Live, they answer detections, or tell of a saved state.
  if (counts_.empty() && others_.empty()) has_unknown_start_ = true;
  Note(objects->seq, &counts_[event.channel]);
}

void AsReceived::Note(int64_t seq, Count* count) const {
  if (!count->first) {
    count->first = seq;
  } else {
    const uint64_t gap = static_cast<uint64_t>(seq) - static_cast<uint64_t>(count->last) - 1;
    const bool goes_on = seq > count->last && gap <= uint64_t{SequenceTracker::kLargestGap};
    if (goes_on) count->num_lost += static_cast<int64_t>(gap);
    if (!goes_on && count->num_restarts++ == 0) count->first_restart = Now();
  }
  count->last = seq;
}

double AsReceived::Now() const {
  return 1e-6 * (static_cast<double>(bus_.NowUtime()) - static_cast<double>(*start_utime_));
}

int64_t AsReceived::num_delivered() const {
  int64_t sum = 0;
  for (const auto& [channel, estimator] : estimators_) sum += estimator.num_delivered;
  return sum;
}

std::vector<std::string> AsReceived::Warnings() const {
  std::vector<std::string> warnings;
  for (const auto& [channel, estimator] : estimators_) {
    const char* name = channel.c_str();
    if (!counts_.contains(channel)) {
      warnings.push_back(Format("%s: the log has none, so nothing of it is computed anew", name));
    }
    if (estimator.num_absent > 0) {
      warnings.push_back(
          Format("%s: %jd messages are of images that the log lacks (the first at "
                 "%.1f s) and can't be computed anew",
                 name,
                 intmax_t{estimator.num_absent},
                 estimator.first_absent));
    }
    if (estimator.num_given_up > 0) {
      warnings.push_back(
          Format("%s: %jd messages (the first at %.1f s) come so long after their "
                 "images that these were given up (%zu MB are held)",
                 name,
                 intmax_t{estimator.num_given_up},
                 estimator.first_absent,
                 most_bytes_ >> 20U));
    }
    if (estimator.num_corrupt > 0) {
      warnings.push_back(Format("%s: %jd messages can't be decoded; their images are not known",
                                name,
                                intmax_t{estimator.num_corrupt}));
    }
  }
  if (has_unknown_start_) {
    warnings.push_back(
        "OBJECTS stand in the log before any detections: fusion knew something already, of a saved "
        "state or from before the recording, that the rerun does not");
  }
  for (const auto& [channel, count] : counts_) {
    const char* name = channel.c_str();
    if (*count.first > 0) {
      warnings.push_back(
          Format("%s begins with seq %jd: what was before it is not in the log, and "
                 "what fusion knew of it neither",
                 name,
                 intmax_t{*count.first}));
    }
    if (count.num_lost > 0) {
      warnings.push_back(
          Format("%s: %jd messages are missing in the log, by gaps in seq; live may "
                 "have used them",
                 name,
                 intmax_t{count.num_lost}));
    }
    if (count.num_restarts > 0) {
      const char* what = channel == "OBJECTS" ? "; the rerun's fusion goes on as one run" : "";
      warnings.push_back(
          Format("%s starts anew %jd times (the first at %.1f s): its process was "
                 "started again%s",
                 name,
                 intmax_t{count.num_restarts},
                 count.first_restart,
                 what));
    }
  }
  for (const auto& [channel, count] : others_) {
    warnings.push_back(
        Format("%s: %jd messages are taken as they were recorded; --estimator says "
               "which are computed anew",
               channel.c_str(),
               intmax_t{count}));
  }
  return warnings;
}

}  // namespace vantage
