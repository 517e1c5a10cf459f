#include "tools/replay/estimate_ahead.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace vantage {
namespace {

constexpr int kStepsAtATime = 256;

// Bit by bit: invalid depth is NaN.
bool IsSameImage(const DepthImage& a, const DepthImage& b) {
  return a.width == b.width && a.height == b.height && a.depth.size() == b.depth.size() &&
         std::memcmp(a.depth.data(), b.depth.data(), a.depth.size() * sizeof(float)) == 0;
}

}  // namespace

struct EstimateAhead::Job {
  enum class State { kWaits, kRuns, kDone, kFailed };

  size_t estimator;
  int64_t event;  // Of the scout, when it asked.
  DepthFrame frame;
  CameraModel camera;
  State state = State::kWaits;
  PoseEstimator::Output output;
  StageTimes times;

  [[nodiscard]] size_t bytes() const { return frame.image.depth.size() * sizeof(float); }
};

EstimateAhead::~EstimateAhead() {
  for (std::jthread& thread : threads_) thread.request_stop();
  threads_.clear();  // Joins.
}

EstimateAhead::Ends EstimateAhead::Add(std::shared_ptr<const PoseEstimator> prototype,
                                       uint64_t seed) {
  const size_t index = estimators_.size();
  estimators_.push_back(std::make_unique<Estimator>(
      Estimator{.prototype = std::move(prototype), .seed = seed, .nothing = {}, .answer = {}}));
  Ends ends;
  ends.ask = [ this, index ](
      const DepthFrame& frame, const CameraModel& camera, StageTimes* times) -> const auto& {
    return Ask(index, frame, camera, times);
  };
  ends.answer = [ this, index ](
      const DepthFrame& frame, const CameraModel& camera, StageTimes* times) -> const auto& {
    return Answer(index, frame, camera, times);
  };
  return ends;
}

void EstimateAhead::Start(Scout scout, int num_threads) {
  scout_ = std::move(scout);
  for (int i = 0; i < num_threads; ++i) {
    threads_.emplace_back([this](const std::stop_token& stop) { Loop(stop); });
  }
}

EstimateAhead::Counters EstimateAhead::counters() const {
  const Lock lock(mutex_);
  return counters_;
}

// On the thread that moves the scout.
const PoseEstimator::Output& EstimateAhead::Ask(size_t estimator,
                                                const DepthFrame& frame,
                                                const CameraModel& camera,
                                                const StageTimes* times) {
  auto job = std::make_shared<Job>(Job{.estimator = estimator,
                                       .event = scout_.num_events(),
                                       .frame = frame,
                                       .camera = camera,
                                       .output = {},
                                       .times = {}});
  if (times != nullptr) job->times.clock = times->clock;
  const Lock lock(mutex_);
  has_asked_ = true;
  job_bytes_ += job->bytes();
  jobs_.push_back(std::move(job));
  changed_.notify_all();
  return estimators_[estimator]->nothing;
}

// On the rerun's thread.
const PoseEstimator::Output& EstimateAhead::Answer(size_t estimator,
                                                   const DepthFrame& frame,
                                                   const CameraModel& camera,
                                                   StageTimes* times) {
  const int64_t event = rerun_events_();
  Lock lock(mutex_);
  while (scout_events_ < event && !is_scout_at_end_) {
    if (is_scout_moving_) {
      changed_.wait(lock);
    } else {
      MoveScout(&lock);
    }
  }
  Forget(event);
  const std::shared_ptr<Job> job = Find(estimator, frame, camera);
  if (!job) ++counters_.num_unasked;
  if (job) {
    while (job->state == Job::State::kRuns) {
      if (!Work(&lock, &rerun_own_)) changed_.wait(lock);
    }
    Remove(job);
    if (job->state == Job::State::kDone) {
      ++counters_.num_taken;
      estimators_[estimator]->answer = job;
      if (times != nullptr) *times = job->times;
      return job->output;
    }
  }
  // Nobody began it, or it failed; then the rerun fails in the same way.
  ++counters_.num_own;
  lock.unlock();
  return OwnOf(estimator, &rerun_own_)(frame, camera, times);
}

const EstimateFunction& EstimateAhead::OwnOf(size_t estimator, Own* own) const {
  own->resize(estimators_.size());
  EstimateFunction& estimate = (*own)[estimator];
  if (!estimate) {
    const Estimator& common = *estimators_[estimator];
    estimate = EstimateBy(common.prototype->Clone(), common.seed);
  }
  return estimate;
}

std::shared_ptr<EstimateAhead::Job> EstimateAhead::Find(size_t estimator,
                                                        const DepthFrame& frame,
                                                        const CameraModel& camera) {
  const auto found = std::ranges::find_if(jobs_, [&](const std::shared_ptr<Job>& job) {
    return job->estimator == estimator && job->frame.utime == frame.utime &&
           job->camera == camera && IsSameImage(job->frame.image, frame.image);
  });
  return found == jobs_.end() ? nullptr : *found;
}

// What the rerun did not come for when it could have.
void EstimateAhead::Forget(int64_t before_event) {
  while (!jobs_.empty() && jobs_.front()->event < before_event) Remove(jobs_.front());
}

void EstimateAhead::Remove(const std::shared_ptr<Job>& job) {
  job_bytes_ -= job->bytes();
  jobs_.erase(std::ranges::find(jobs_, job));
  changed_.notify_all();  // There is room again.
}

bool EstimateAhead::HasWork() const {
  const bool may_scout =
      !is_scout_moving_ && !is_scout_at_end_ && (jobs_.empty() || job_bytes_ < most_bytes_);
  return may_scout || std::ranges::any_of(
                          jobs_, [](const auto& job) { return job->state == Job::State::kWaits; });
}

// Does one thing that there is to do, unlocked. @return false: there is none.
bool EstimateAhead::Work(Lock* lock, Own* own) {
  if (!HasWork()) return false;
  const auto waiting =
      std::ranges::find_if(jobs_, [](const auto& job) { return job->state == Job::State::kWaits; });
  if (waiting == jobs_.end()) {
    MoveScout(lock);
    return true;
  }
  const std::shared_ptr<Job> job = *waiting;
  job->state = Job::State::kRuns;
  lock->unlock();
  bool done = true;
  try {
    job->output = OwnOf(job->estimator, own)(job->frame, job->camera, &job->times);
  } catch (const std::exception&) {
    done = false;
  }
  lock->lock();
  job->state = done ? Job::State::kDone : Job::State::kFailed;
  changed_.notify_all();
  return true;
}

void EstimateAhead::MoveScout(Lock* lock) {
  is_scout_moving_ = true;
  has_asked_ = false;
  lock->unlock();
  bool goes_on = true;
  for (int i = 0; i < kStepsAtATime && goes_on && !has_asked_; ++i) goes_on = scout_.step();
  const int64_t num_events = scout_.num_events();
  lock->lock();
  is_scout_moving_ = false;
  is_scout_at_end_ = !goes_on;
  scout_events_ = num_events;
  changed_.notify_all();
}

void EstimateAhead::Loop(const std::stop_token& stop) {
  Own own;
  Lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (!Work(&lock, &own)) changed_.wait(lock, stop, [this] { return HasWork(); });
  }
}

}  // namespace vantage
