#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "common/camera_model.h"
#include "nodes/estimator_node.h"
#include "perception/estimator/pose_estimator.h"

namespace vantage {

/// Estimates of images that a rerun will come to, made on other threads before it does.
///
/// What an estimator finds depends on the image, its camera and its time alone. So a second set of
/// nodes, the scout, goes over the same log ahead of the rerun. Its estimators find nothing: they
/// ask for estimates of their images. The rerun's estimators take an estimate that was asked for
/// with exactly their image, and compute any other themselves: what the scout does can change how
/// long a rerun takes, never its result.
///
/// No thread waits while there is work: that of the rerun estimates, too, while it waits for an
/// estimate, and any thread moves the scout on when nothing is left to estimate.
class EstimateAhead {
 public:
  /// For one estimator of scout and rerun.
  struct Ends {
    EstimateFunction ask;     ///< of the scout: finds nothing
    EstimateFunction answer;  ///< of the rerun, on one thread
  };
  struct Scout {
    std::function<bool()> step;           ///< the next event; false at the end
    std::function<int64_t()> num_events;  ///< that it began
  };

  /// @param rerun_events events that the rerun began.
  /// @param most_bytes of images that wait for the rerun; one may be larger.
  EstimateAhead(std::function<int64_t()> rerun_events, size_t most_bytes)
      : rerun_events_(std::move(rerun_events)), most_bytes_(most_bytes) {}
  /// Ends what is under way; nothing of the scout is called after.
  ~EstimateAhead();
  EstimateAhead(const EstimateAhead&) = delete;
  EstimateAhead& operator=(const EstimateAhead&) = delete;

  /// Before Start(). `prototype` is cloned.
  Ends Add(std::shared_ptr<const PoseEstimator> prototype, uint64_t seed);
  /// @param num_threads beside the rerun's, 0 or more.
  void Start(Scout scout, int num_threads);

  struct Counters {
    int64_t num_taken = 0;    ///< estimates that were made ahead
    int64_t num_own = 0;      ///< estimates that the rerun made when it came to them
    int64_t num_unasked = 0;  ///< of these, such that the scout had not asked for
  };
  [[nodiscard]] Counters counters() const;

 private:
  struct Job;
  struct Estimator {
    std::shared_ptr<const PoseEstimator> prototype;
    uint64_t seed;
    PoseEstimator::Output nothing;
    std::shared_ptr<Job> answer;  // Of which the last answer is part.
  };
  /// The estimators of one thread; those not used yet are empty.
  using Own = std::vector<EstimateFunction>;
  using Lock = std::unique_lock<std::mutex>;

  const PoseEstimator::Output& Ask(size_t estimator,
                                   const DepthFrame& frame,
                                   const CameraModel& camera,
                                   const StageTimes* times);
  const PoseEstimator::Output& Answer(size_t estimator,
                                      const DepthFrame& frame,
                                      const CameraModel& camera,
                                      StageTimes* times);
  const EstimateFunction& OwnOf(size_t estimator, Own* own) const;
  std::shared_ptr<Job> Find(size_t estimator, const DepthFrame& frame, const CameraModel& camera);
  void Forget(int64_t before_event);
  void Remove(const std::shared_ptr<Job>& job);
  [[nodiscard]] bool HasWork() const;
  bool Work(Lock* lock, Own* own);
  void MoveScout(Lock* lock);
  void Loop(const std::stop_token& stop);

  std::function<int64_t()> rerun_events_;
  size_t most_bytes_;
  std::vector<std::unique_ptr<Estimator>> estimators_;
  Own rerun_own_;

  mutable std::mutex mutex_;  // Of all that follows.
  std::condition_variable_any changed_;
  Scout scout_;
  bool is_scout_moving_ = false;
  bool is_scout_at_end_ = false;
  bool has_asked_ = false;                 // In this move.
  int64_t scout_events_ = 0;               // That it is done with.
  std::deque<std::shared_ptr<Job>> jobs_;  // Not taken yet, in the order of the log.
  size_t job_bytes_ = 0;
  Counters counters_;
  std::vector<std::jthread> threads_;
};

}  // namespace vantage
