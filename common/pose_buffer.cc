#include "common/pose_buffer.h"

#include <algorithm>

#include "common/time_range.h"

namespace vantage {

bool PoseBuffer::Add(int64_t utime, const Pose& T_world_camera) {
  if (!IsPlausibleUtime(utime)) return false;
  const bool starts_anew =
      !entries_.empty() && utime < entries_.back().utime - parameters_.largest_gap_us;
  if (starts_anew) entries_.clear();
  Entry entry{utime, T_world_camera.translation(), Eigen::Quaterniond(T_world_camera.linear())};
  const auto place =
      std::lower_bound(entries_.begin(), entries_.end(), utime, [](const Entry& a, int64_t b) {
        return a.utime < b;
      });
  if (place != entries_.end() && place->utime == utime) {
    *place = entry;
  } else {
    entries_.insert(place, entry);
  }
  while (entries_.front().utime < entries_.back().utime - parameters_.horizon_us) {
    entries_.pop_front();
  }
  return starts_anew;
}

std::optional<Pose> PoseBuffer::At(int64_t utime) const {
  const auto after =
      std::lower_bound(entries_.begin(), entries_.end(), utime, [](const Entry& a, int64_t b) {
        return a.utime < b;
      });
  if (after == entries_.end()) return std::nullopt;
  Pose pose = Pose::Identity();
  if (after->utime == utime) {
    pose.linear() = after->rotation.toRotationMatrix();
    pose.translation() = after->translation;
    return pose;
  }
  if (after == entries_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const int64_t gap = after->utime - before->utime;
  if (gap > parameters_.largest_gap_us) return std::nullopt;
  const double fraction = static_cast<double>(utime - before->utime) / static_cast<double>(gap);
  pose.linear() = before->rotation.slerp(fraction, after->rotation).toRotationMatrix();
  pose.translation() = before->translation + fraction * (after->translation - before->translation);
  return pose;
}

bool PoseBuffer::RestsAt(int64_t utime, int64_t window_us) const {
  const std::optional<Pose> middle = At(utime);
  if (!middle || !At(utime - window_us) || !At(utime + window_us)) return false;
  const Eigen::Quaterniond rotation(middle->linear());
  int64_t previous = 0;
  bool has_previous = false;
  for (const Entry& entry : entries_) {
    if (entry.utime < utime - window_us || entry.utime > utime + window_us) continue;
    if (has_previous && entry.utime - previous > parameters_.largest_gap_us) return false;
    previous = entry.utime;
    has_previous = true;
    if ((entry.translation - middle->translation()).norm() > parameters_.rest_translation) {
      return false;
    }
    if (GeodesicAngle(entry.rotation, rotation) > parameters_.rest_rotation) return false;
  }
  return true;
}

std::optional<int64_t> PoseBuffer::Newest() const {
  if (entries_.empty()) return std::nullopt;
  return entries_.back().utime;
}

}  // namespace vantage
