#pragma once

#include <chrono>
#include <map>
#include <string>

namespace vantage {

/// Milliseconds of the named stages of one estimate, one after the other. A stage that begins again
/// goes on.
class StageClock {
 public:
  void Begin(const std::string& stage) {
    End();
    stage_ = stage;
    start_ = Clock::now();
  }
  void End() {
    if (!stage_.empty()) Add(stage_, std::chrono::duration<double>(Clock::now() - start_).count());
    stage_.clear();
  }
  /// A stage that was measured otherwise, s.
  void Add(const std::string& stage, double seconds) { ms_[stage] += 1e3 * seconds; }

  [[nodiscard]] const std::map<std::string, double>& ms() const { return ms_; }
  [[nodiscard]] double total_ms() const {
    double sum = 0.0;
    for (const auto& [stage, ms] : ms_) sum += ms;
    return sum;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::map<std::string, double> ms_;
  std::string stage_;
  Clock::time_point start_;
};

}  // namespace vantage
