#include "perception/calibration/hand_trajectory.h"

#include <algorithm>

namespace vantage {

HandTrajectory::HandTrajectory(std::vector<Sample> samples) : samples_(std::move(samples)) {
  std::stable_sort(samples_.begin(), samples_.end(), [](const Sample& a, const Sample& b) {
    return a.utime < b.utime;
  });
  // Of equal times the last one stays.
  std::vector<Sample> unique;
  for (const Sample& sample : samples_) {
    if (!unique.empty() && unique.back().utime == sample.utime) unique.pop_back();
    unique.push_back(sample);
  }
  samples_ = std::move(unique);
}

std::optional<Pose> HandTrajectory::At(double utime_us, double largest_gap_us) const {
  const auto after = std::lower_bound(
      samples_.begin(), samples_.end(), utime_us, [](const Sample& sample, double utime) {
        return static_cast<double>(sample.utime) < utime;
      });
  if (after == samples_.end()) return std::nullopt;
  if (static_cast<double>(after->utime) == utime_us) return after->T_base_hand;
  if (after == samples_.begin()) return std::nullopt;
  const Sample& before = *std::prev(after);
  const double gap = static_cast<double>(after->utime - before.utime);
  if (gap > largest_gap_us) return std::nullopt;
  const double fraction = (utime_us - static_cast<double>(before.utime)) / gap;
  const Eigen::Quaterniond from(before.T_base_hand.linear());
  const Eigen::Quaterniond to(after->T_base_hand.linear());
  Pose pose = Pose::Identity();
  pose.linear() = from.slerp(fraction, to).toRotationMatrix();
  pose.translation() = (1.0 - fraction) * before.T_base_hand.translation() +
                       fraction * after->T_base_hand.translation();
  return pose;
}

}  // namespace vantage
