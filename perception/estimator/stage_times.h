#pragma once

#include <functional>

namespace vantage {

/// Seconds that the stages of one call took, by the caller's clock.
struct StageTimes {
  std::function<double()> clock;  ///< s
  double segmentation = 0.0;
  double normals = 0.0;   ///< scene points and their normals
  double proposal = 0.0;  ///< voting, or matching and RANSAC
  double verification = 0.0;
  double refinement = 0.0;
};

/// Adds the seconds of its life to a stage of `times`, which may be null.
class StageTimer {
 public:
  StageTimer(StageTimes* times, double StageTimes::*stage)
      : times_(times != nullptr && times->clock ? times : nullptr), stage_(stage) {
    if (times_ != nullptr) start_ = times_->clock();
  }
  ~StageTimer() {
    if (times_ != nullptr) times_->*stage_ += times_->clock() - start_;
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageTimes* times_;
  double StageTimes::*stage_;
  double start_ = 0.0;
};

}  // namespace vantage
