#include "tools/log/odd_value.h"

#include <bit>

namespace vantage {
namespace {

constexpr int64_t kLongestPause = 86'400'000'000;  // us, a day

// Wraps around where hostile values would overflow.
int64_t Plus(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) + static_cast<uint64_t>(b));
}

bool IsOneBitOff(int64_t a, int64_t b) { return std::popcount(static_cast<uint64_t>(a ^ b)) == 1; }

// later - earlier, as great as it may be.
double Apart(int64_t earlier, int64_t later) {
  return static_cast<double>(later) - static_cast<double>(earlier);
}

}  // namespace

std::optional<OddValue> CountRow::Add(int64_t value, const EventPlace& place) {
  std::optional<OddValue> odd;
  if (num_values_++ == 0) {
    first_place_ = place;
    last_ = value;
  } else if (!open_) {
    if (value == Plus(last_, 1)) {
      last_ = value;
    } else {
      open_ = OddValue{.place = place, .value = value, .expected = Plus(last_, 1)};
    }
  } else {
    if (value == Plus(last_, 2)) {
      odd = open_;
    } else if (num_values_ == 3 && value == Plus(open_->value, 1) &&
               IsOneBitOff(last_, Plus(value, -2))) {
      odd = OddValue{.place = first_place_, .value = last_, .expected = Plus(value, -2)};
    } else {
      ++num_jumps_;
    }
    open_.reset();
    last_ = value;
  }
  return odd;
}

std::optional<OddValue> CountRow::Finish() const {
  if (open_ && IsOneBitOff(open_->value, open_->expected)) return open_;
  return {};
}

std::optional<OddValue> TimeRow::Add(int64_t utime, const EventPlace& place) {
  std::optional<OddValue> odd;
  if (num_values_++ == 0) {
    before_ = utime;
    first_place_ = place;
    return {};
  }
  if (open_) {
    const int64_t now = open_->value;
    const bool fits = *before_ <= now && now <= utime;
    if (!fits && *before_ <= utime) {
      odd = open_;
      odd->expected = now < *before_ ? *before_ : utime;
    } else {
      const bool first_is_late = num_values_ == 3 && *before_ > now && now <= utime;
      const bool first_is_early = num_values_ == 3 && Apart(*before_, now) > kLongestPause;
      if (first_is_late || first_is_early) {
        odd = OddValue{.place = first_place_, .value = *before_, .expected = now};
      }
      before_ = now;
    }
  }
  open_ = OddValue{.place = place, .value = utime, .expected = utime};
  return odd;
}

std::optional<OddValue> TimeRow::Finish() const {
  if (!open_) return {};
  const double pause = Apart(*before_, open_->value);
  if (pause >= 0.0 && pause <= kLongestPause) return {};
  OddValue odd = *open_;
  odd.expected = *before_;
  return odd;
}

}  // namespace vantage
