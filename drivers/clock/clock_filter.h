#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Tells when, on the host's clock, a device measured. The device stamps its measurements with its
/// own clock and the host sees them arrive after a latency that is never negative, mostly short and
/// sometimes long. So the points (device time, arrival - device time) lie above the line of the two
/// clocks' true relation and touch it where the latency was least. The line is found as the edge of
/// the points' lower convex hull below their mean, which of all lines under the points has the
/// least mean distance to them (Zhang, Liu and Xia, "Clock synchronization algorithms for network
/// measurements", INFOCOM 2002), over a sliding window, so that it follows drift.
///
/// The least latency itself can't be seen from here; the result is late by it.
class ClockFilter {
 public:
  struct Parameters {
    /// us at which device time wraps to 0, if it does: stamps of 32 bits do. 0: it never does.
    int64_t device_modulus_us = int64_t{1} << 32;
    int64_t window_us = 40'000'000;      ///< us of device time that the line is fitted to
    int64_t bucket_us = 500'000;         ///< us; of each bucket the lowest point is kept
    int64_t skew_after_us = 5'000'000;   ///< us of points before a skew is estimated
    double max_skew_ppm = 500.0;         ///< crystals are good to 100 ppm; twice that, and margin
    int64_t step_us = 20'000;            ///< us; a clock that jumps by less is taken for drift
    int64_t step_confirm_us = 500'000;   ///< us for which lateness must last to be a step
    int step_confirm_frames = 5;         ///< and for at least so many measurements
    int64_t longest_stall_us = 400'000;  ///< us; the first arrivals may be late by as much

    Result<void> Validate() const;
  };

  ClockFilter() : ClockFilter(Parameters{}) {}
  explicit ClockFilter(const Parameters& parameters);

  /// @param device_us the device's stamp, us.
  /// @param arrival_us host time at arrival, us; its clock may be set at any time.
  /// @return host time of the measurement, us: never after `arrival_us`, and later than every
  ///     result before, except where a clock stepped (or measurements arrived within 1 us).
  int64_t Update(int64_t device_us, int64_t arrival_us);
  /// Forgets everything but num_steps(): for another device, or the same opened again.
  /// @param device_modulus_us as in Parameters.
  void Reset(int64_t device_modulus_us);

  /// Host time minus (unwrapped) device time at the last measurement, us; 0 before the first.
  [[nodiscard]] double offset_us() const;
  /// How much faster the host's clock runs than the device's, parts per million.
  [[nodiscard]] double skew_ppm() const { return 1e6 * slope_; }
  /// Times that a clock was found to have stepped or started anew.
  [[nodiscard]] int num_steps() const { return num_steps_; }

 private:
  // One measurement, relative to the first since the start or the last step.
  struct Point {
    double device;  // us
    double offset;  // us, arrival minus device, both relative
  };

  [[nodiscard]] double LineAt(double device) const { return intercept_ + slope_ * device; }
  // Unwraps; nothing when the device's clock went back.
  [[nodiscard]] std::optional<int64_t> Unwrap(int64_t device_us) const;
  [[nodiscard]] bool IsStep(const Point& point);
  void Forget();
  void StartAt(int64_t device_us, int64_t arrival_us);
  void Keep(const Point& point);
  void FitLine();

  Parameters parameters_;
  bool started_ = false;
  int64_t raw_device_us_ = 0;     // Last stamp as it came.
  int64_t device_us_ = 0;         // Last stamp, unwrapped.
  int64_t first_device_us_ = 0;   // What points are relative to.
  int64_t first_arrival_us_ = 0;  // What points are relative to.
  int64_t last_result_us_ = 0;
  std::vector<Point> lowest_;  // Of each bucket, oldest first; the newest bucket is open.
  std::vector<Point> hull_;    // Reused.
  double slope_ = 0.0;
  double intercept_ = 0.0;
  double late_since_ = 0.0;  // us, device time at which an unbroken run of lateness began
  int num_late_ = 0;
  int num_steps_ = 0;
};

}  // namespace vantage
