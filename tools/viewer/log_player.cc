#include "tools/viewer/log_player.h"

#include <algorithm>
#include <utility>

#include "common/format.h"

namespace vantage {

Result<std::unique_ptr<LogPlayer>> LogPlayer::Open(const std::filesystem::path& log,
                                                   const SceneCloud::Parameters& cloud) {
  std::unique_ptr<LogPlayer> player(new LogPlayer(log, cloud));
  if (Result<void> opened = player->Restart(); !opened) return opened.error();
  if (!player->next_) {
    return Error{ErrorCode::kNotFound,
                 Format("log %s has no event, expected a recording of a run", log.c_str())};
  }
  player->start_utime_ = player->next_utime_;
  player->end_utime_ = player->next_utime_;
  return player;
}

Result<void> LogPlayer::Restart() {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log_);
  if (!reader) return reader.error();
  reader_ = std::move(reader).value();
  state_ = ViewerState(cloud_);
  num_events_ = 0;
  next_utime_ = 0;
  ReadNext();
  return {};
}

void LogPlayer::ReadNext() {
  next_ = reader_->NextView();
  if (next_) next_utime_ = std::max(next_utime_, next_->utime);
}

void LogPlayer::ApplyNext() {
  state_.Apply(std::string(next_->channel), next_utime_, next_->data);
  ++num_events_;
  ReadNext();
}

Result<void> LogPlayer::Survey(const std::function<void(double share)>& progress) {
  while (next_) {
    const std::string channel(next_->channel);
    end_utime_ = next_utime_;
    ApplyNext();
    Mark(channel);
    if (num_events_ % keyframe_interval_ == 0) KeepKeyframe();
    if (num_events_ % 256 == 0) progress(reader_->progress());
  }
  if (reader_->damage().any()) damage_ = reader_->damage().Describe();
  if (state_.num_used() == 0) {
    return Error{ErrorCode::kNotFound,
                 Format("log %s has no message that can be shown in its %jd events, expected "
                        "CAMERA_*, DETECTIONS_*, OBJECTS, ORIENTATION_HISTOGRAM or NEXT_VIEW",
                        log_.c_str(),
                        intmax_t{num_events_})};
  }
  return {};
}

void LogPlayer::Mark(const std::string& channel) {
  if (marks_.size() >= kMaxMarks) return;
  if (channel == "OBJECTS" || channel == "NEXT_VIEW" || channel.starts_with("DETECTIONS_")) {
    if (marks_.empty() || marks_.back() < state_.utime()) marks_.push_back(state_.utime());
  }
  const int num_viewpoints = state_.objects().num_viewpoints;
  if (num_viewpoints != num_viewpoints_ && num_viewpoints > 0) views_.push_back(state_.utime());
  num_viewpoints_ = num_viewpoints;
}

// When there are too many, every second one goes.
void LogPlayer::KeepKeyframe() {
  if (!next_) return;
  keyframes_.push_back({state_.utime(), num_events_, next_->offset, state_});
  if (keyframes_.size() < kMaxKeyframes) return;
  for (size_t i = 0; 2 * i + 1 < keyframes_.size(); ++i) {
    keyframes_[i] = std::move(keyframes_[2 * i + 1]);
  }
  keyframes_.resize(keyframes_.size() / 2);
  keyframe_interval_ *= 2;
}

// Where times of events go back, the seek may miss the place: then it is read up to there.
bool LogPlayer::MoveTo(const Keyframe& keyframe) {
  reader_->SeekUtime(keyframe.utime);
  ReadNext();
  if ((!next_ || next_->offset > keyframe.next_offset) && !Restart()) return false;
  while (next_ && next_->offset < keyframe.next_offset) ReadNext();
  num_events_ = keyframe.num_events;
  state_ = keyframe.state;
  next_utime_ = keyframe.utime;
  if (next_) next_utime_ = std::max(next_utime_, next_->utime);
  return true;
}

void LogPlayer::GoTo(int64_t utime) {
  // The newest one from which only events of up to `utime` follow.
  const Keyframe* best = nullptr;
  for (const Keyframe& keyframe : keyframes_) {
    if (keyframe.utime <= utime) best = &keyframe;
  }
  const bool is_past = num_events_ > 0 && state_.utime() > utime;
  if (best != nullptr && (is_past || best->num_events > num_events_)) {
    if (!MoveTo(*best)) return;  // The file went away: what was shown stays.
  } else if (is_past && !Restart()) {
    return;
  }
  while (next_ && next_utime_ <= utime) ApplyNext();
}

std::string LogPlayer::Damage() const { return damage_; }

}  // namespace vantage
