#include "drivers/camera/frame_pairing.h"

namespace vantage {
namespace {

constexpr int kPatience = 4;  // images for which a silent color stream is waited for

}  // namespace

int64_t FramePairing::Difference(int64_t a_us, int64_t b_us) const {
  // Unsigned: stamps from outside must not overflow.
  const uint64_t difference = static_cast<uint64_t>(a_us) - static_cast<uint64_t>(b_us);
  if (options_.modulus_us <= 0) return static_cast<int64_t>(difference);
  const int64_t modulus = options_.modulus_us;
  int64_t rest = static_cast<int64_t>(difference) % modulus;
  if (rest < -modulus / 2) rest += modulus;
  if (rest > modulus / 2) rest -= modulus;
  return rest;
}

int FramePairing::SlotToReuse() const {
  int chosen = 0;
  for (int i = 1; i < kNumSlots; ++i) {
    const Slot& slot = slots_[static_cast<size_t>(i)];
    const Slot& best = slots_[static_cast<size_t>(chosen)];
    // An image that waits is given up only when all do.
    if (slot.waits != best.waits ? best.waits : slot.used_order < best.used_order) chosen = i;
  }
  return chosen;
}

int FramePairing::Offer(int64_t color_us) {
  num_depth_since_color_ = 0;
  const int64_t step_us = newest_us_ ? Difference(color_us, *newest_us_) : 1;
  if (step_us < 0) {
    for (Slot& slot : slots_) slot.waits = false;
  }
  int chosen = SlotToReuse();
  bool waits = true;
  if (step_us == 0) {
    waits = false;  // It was taken or given up, unless it is found waiting.
    for (int i = 0; i < kNumSlots; ++i) {
      const Slot& slot = slots_[static_cast<size_t>(i)];
      if (!slot.waits || Difference(slot.stamp_us, color_us) != 0) continue;
      chosen = i;
      waits = true;
    }
  }
  newest_us_ = color_us;
  slots_[static_cast<size_t>(chosen)] = {color_us, waits, ++order_};
  return chosen;
}

int FramePairing::Nearest(int64_t depth_us) const {
  int nearest = -1;
  int64_t least_us = options_.depth_period_us / 2;
  for (int i = 0; i < kNumSlots; ++i) {
    const Slot& slot = slots_[static_cast<size_t>(i)];
    if (!slot.waits) continue;
    const int64_t delay_us = Difference(slot.stamp_us, depth_us);
    if (delay_us < -least_us || delay_us > least_us) continue;
    const int64_t distance_us = delay_us < 0 ? -delay_us : delay_us;
    // Of two that are equally far the one that came first.
    if (nearest >= 0 && distance_us == least_us &&
        slots_[static_cast<size_t>(nearest)].used_order < slot.used_order) {
      continue;
    }
    least_us = distance_us;
    nearest = i;
  }
  return nearest;
}

bool FramePairing::ShouldWait(int64_t depth_us) const {
  if (num_depth_since_color_ >= kPatience) return false;
  if (!newest_us_) return true;
  const int64_t newest_us = Difference(*newest_us_, depth_us);
  if (newest_us >= 0 || newest_us < -kPatience * options_.color_period_us) return false;
  const int64_t expected_us = newest_us + options_.color_period_us;
  const int nearest = Nearest(depth_us);
  if (nearest < 0) {
    // A quarter of a period for jitter.
    return expected_us <= options_.depth_period_us / 2 + options_.color_period_us / 4;
  }
  const int64_t delay_us = Difference(slots_[static_cast<size_t>(nearest)].stamp_us, depth_us);
  return expected_us < -delay_us;
}

std::optional<FramePairing::Match> FramePairing::Take(int64_t depth_us) {
  if (num_depth_since_color_ < kPatience) ++num_depth_since_color_;
  const int nearest = Nearest(depth_us);
  std::optional<Match> match;
  int64_t oldest_kept_us = -options_.depth_period_us / 2;
  if (nearest >= 0) {
    Slot& slot = slots_[static_cast<size_t>(nearest)];
    match = Match{nearest, Difference(slot.stamp_us, depth_us)};
    slot.used_order = ++order_;
    oldest_kept_us = match->delay_us + 1;
  }
  for (Slot& slot : slots_) {
    if (Difference(slot.stamp_us, depth_us) < oldest_kept_us) slot.waits = false;
  }
  return match;
}

}  // namespace vantage
