#include "drivers/clock/clock_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/format.h"

namespace vantage {
namespace {

// > 0 where b lies below the line from a to c.
template <class Point>
double Convexity(const Point& a, const Point& b, const Point& c) {
  return (b.device - a.device) * (c.offset - a.offset) -
         (c.device - a.device) * (b.offset - a.offset);
}

}  // namespace

Result<void> ClockFilter::Parameters::Validate() const {
  const auto check = [](const char* name, double value, double lowest) -> Result<void> {
    if (value >= lowest) return {};
    return Error{ErrorCode::kInvalidArgument,
                 Format("clock filter: %s = %g, expected %g or more", name, value, lowest)};
  };
  const struct {
    const char* name;
    double value;
    double lowest;
  } bounds[] = {{"device_modulus_us", static_cast<double>(device_modulus_us), 0},
                {"bucket_us", static_cast<double>(bucket_us), 1},
                {"window_us", static_cast<double>(window_us), 2.0 * static_cast<double>(bucket_us)},
                {"skew_after_us", static_cast<double>(skew_after_us), 1},
                {"max_skew_ppm", max_skew_ppm, 0},
                {"step_us", static_cast<double>(step_us), 1},
                {"step_confirm_us", static_cast<double>(step_confirm_us), 1},
                {"step_confirm_frames", static_cast<double>(step_confirm_frames), 1},
                {"longest_stall_us", static_cast<double>(longest_stall_us), 0}};
  for (const auto& bound : bounds) {
    if (Result<void> good = check(bound.name, bound.value, bound.lowest); !good) return good;
  }
  return {};
}

ClockFilter::ClockFilter(const Parameters& parameters) : parameters_(parameters) {
  const Result<void> valid = parameters_.Validate();
  VANTAGE_CHECK(valid.ok(), valid.error().message);
}

void ClockFilter::Reset(int64_t device_modulus_us) {
  parameters_.device_modulus_us = device_modulus_us;
  Forget();
}

void ClockFilter::Forget() {
  started_ = false;
  slope_ = 0.0;
  intercept_ = 0.0;
  lowest_.clear();
  num_late_ = 0;
}

double ClockFilter::offset_us() const {
  if (!started_) return 0.0;
  return static_cast<double>(first_arrival_us_ - first_device_us_) +
         LineAt(static_cast<double>(device_us_ - first_device_us_));
}

int64_t ClockFilter::Update(int64_t device_us, int64_t arrival_us) {
  const std::optional<int64_t> unwrapped = started_ ? Unwrap(device_us) : std::nullopt;
  if (!unwrapped) {
    if (started_) ++num_steps_;
    StartAt(device_us, arrival_us);
    return arrival_us;
  }
  const double device = static_cast<double>(*unwrapped - first_device_us_);
  const Point point{device, static_cast<double>(arrival_us - first_arrival_us_) - device};
  if (IsStep(point)) {
    ++num_steps_;
    StartAt(device_us, arrival_us);
    return arrival_us;
  }
  raw_device_us_ = device_us;
  device_us_ = *unwrapped;
  Keep(point);

  const int64_t measured =
      first_arrival_us_ + static_cast<int64_t>(std::floor(device + LineAt(device)));
  last_result_us_ = std::min(arrival_us, std::max(measured, last_result_us_ + 1));
  return last_result_us_;
}

std::optional<int64_t> ClockFilter::Unwrap(int64_t device_us) const {
  int64_t forward = device_us - raw_device_us_;
  const int64_t modulus = parameters_.device_modulus_us;
  // A wrap, unless it would be a leap of half the range: then the device started anew.
  if (modulus > 0 && forward < 0 && forward + modulus < modulus / 2) forward += modulus;
  if (forward < 0 || forward > parameters_.window_us) return std::nullopt;
  return device_us_ + forward;
}

bool ClockFilter::IsStep(const Point& point) {
  const double residual = point.offset - LineAt(point.device);
  const double step = static_cast<double>(parameters_.step_us);
  const double since_last =
      point.device + point.offset - static_cast<double>(last_result_us_ - first_arrival_us_);
  if (since_last < 0.0) return true;
  if (residual < 0.0) {
    num_late_ = 0;
    // Before the measurement, so the host's clock was set back; but while little is known the
    // arrivals seen may all have been late ones.
    const double known = lowest_.back().device - lowest_.front().device;
    const bool starting = known < static_cast<double>(parameters_.skew_after_us);
    return -residual > (starting ? static_cast<double>(parameters_.longest_stall_us) : step);
  }
  if (residual < step) {
    num_late_ = 0;
    return false;
  }
  // Late: a stall, which passes, or a step, which stays.
  if (num_late_ == 0) late_since_ = point.device;
  ++num_late_;
  return num_late_ >= parameters_.step_confirm_frames &&
         point.device - late_since_ >= static_cast<double>(parameters_.step_confirm_us);
}

void ClockFilter::StartAt(int64_t device_us, int64_t arrival_us) {
  Forget();
  started_ = true;
  raw_device_us_ = device_us;
  device_us_ = device_us;
  first_device_us_ = device_us;
  first_arrival_us_ = arrival_us;
  last_result_us_ = arrival_us;
  lowest_.push_back({0.0, 0.0});
}

void ClockFilter::Keep(const Point& point) {
  const auto bucket = [this](const Point& each) {
    return std::floor(each.device / static_cast<double>(parameters_.bucket_us));
  };
  const bool below = point.offset < LineAt(point.device);
  if (bucket(point) != bucket(lowest_.back())) {
    lowest_.push_back(point);
    const double oldest = point.device - static_cast<double>(parameters_.window_us);
    std::erase_if(lowest_, [oldest](const Point& each) { return each.device < oldest; });
    FitLine();
  } else if (point.offset - slope_ * point.device <
             lowest_.back().offset - slope_ * lowest_.back().device) {
    lowest_.back() = point;
    if (below) FitLine();
  }
}

void ClockFilter::FitLine() {
  // Lower hull, left to right (Andrew's monotone chain).
  hull_.clear();
  double mean_device = 0.0;
  for (const Point& point : lowest_) {
    while (hull_.size() >= 2 && Convexity(hull_[hull_.size() - 2], hull_.back(), point) <= 0.0) {
      hull_.pop_back();
    }
    hull_.push_back(point);
    mean_device += point.device / static_cast<double>(lowest_.size());
  }
  const double span = lowest_.back().device - lowest_.front().device;
  slope_ = 0.0;
  if (span >= static_cast<double>(parameters_.skew_after_us)) {
    size_t right = 1;
    while (right + 1 < hull_.size() && hull_[right].device < mean_device) ++right;
    const double slope = (hull_[right].offset - hull_[right - 1].offset) /
                         (hull_[right].device - hull_[right - 1].device);
    const double bound = 1e-6 * parameters_.max_skew_ppm;
    slope_ = std::clamp(slope, -bound, bound);
  }
  intercept_ = std::numeric_limits<double>::infinity();
  for (const Point& point : hull_) {
    intercept_ = std::min(intercept_, point.offset - slope_ * point.device);
  }
}

}  // namespace vantage
