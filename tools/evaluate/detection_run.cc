#include "tools/evaluate/detection_run.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "common/format.h"
#include "tools/evaluate/detection_cache.h"
#include "tools/evaluate/detection_key.h"

namespace vantage {
namespace {

// The sequences of one model and kind.
struct Group {
  size_t model = 0;
  SequenceKind kind = SequenceKind::kRandom;
  int count = 0;  // requested
  DetectionCache cache;
  std::map<int, DetectionSequence> waiting;  // Done, but one before it is not.

  [[nodiscard]] int num_present() const { return static_cast<int>(cache.sequences().size()); }
};

struct Task {
  size_t group = 0;
  int index = 0;
};

// Hands sequences to threads and takes them back, in order into the files.
class Work {
 public:
  Work(std::span<const ObjectModel> models,
       const DetectionRequest& request,
       std::vector<Group> groups,
       const std::function<void(const DetectionProgress&)>& progress)
      : models_(models), request_(request), groups_(std::move(groups)), progress_(progress) {
    for (size_t group = 0; group < groups_.size(); ++group) {
      for (int index = groups_[group].num_present(); index < groups_[group].count; ++index) {
        tasks_.push_back({group, index});
        done_.views_total += NumViews(groups_[group]);
      }
    }
  }

  Result<void> Run(const std::stop_token& stop) {
    if (tasks_.empty()) return {};
    if (progress_) progress_(done_);
    {
      std::vector<std::jthread> threads;
      const size_t count = std::min(tasks_.size(), static_cast<size_t>(request_.threads));
      for (size_t i = 0; i < count; ++i) {
        threads.emplace_back([this, &stop] { RunThread(stop); });
      }
    }
    if (error_) return *error_;
    return {};
  }

  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }
  [[nodiscard]] int64_t views_made() const { return done_.views_done; }
  [[nodiscard]] int NumViews(const Group& group) const {
    return request_.simulation.views.NumViews(group.kind);
  }

 private:
  void RunThread(const std::stop_token& stop) {
    std::unique_ptr<SequenceSimulator> simulator;
    std::optional<size_t> model;  // Of the simulator.
    while (const std::optional<Task> task = Next(stop)) {
      const Group& group = groups_[task->group];
      if (model != group.model) {
        simulator.reset();  // Its tables go before others come.
        Result<std::unique_ptr<SequenceSimulator>> created =
            SequenceSimulator::Create(models_[group.model], request_.simulation);
        if (!created) return Fail(created.error());
        simulator = std::move(created).value();
        model = group.model;
      }
      Finish(*task, simulator->Simulate(group.kind, task->index));
    }
  }

  std::optional<Task> Next(const std::stop_token& stop) {
    const std::lock_guard lock(mutex_);
    if (stop.stop_requested() || error_ || next_ == tasks_.size()) return std::nullopt;
    return tasks_[next_++];
  }

  void Finish(const Task& task, DetectionSequence sequence) {
    const std::lock_guard lock(mutex_);
    Group& group = groups_[task.group];
    group.waiting.emplace(task.index, std::move(sequence));
    while (!group.waiting.empty() && group.waiting.begin()->first == group.num_present()) {
      DetectionSequence next = std::move(group.waiting.extract(group.waiting.begin()).mapped());
      if (Result<void> appended = group.cache.Append(std::move(next)); !appended) {
        if (!error_) error_ = appended.error();
        return;
      }
    }
    done_.views_done += NumViews(group);
    done_.model_id = models_[group.model].id;
    if (progress_) progress_(done_);
  }

  void Fail(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = error;
  }

  std::span<const ObjectModel> models_;
  const DetectionRequest& request_;
  std::vector<Group> groups_;  // Of each its cache and what waits are guarded by the mutex.
  const std::function<void(const DetectionProgress&)>& progress_;
  std::vector<Task> tasks_;
  std::mutex mutex_;
  size_t next_ = 0;  // Guarded, as what follows.
  DetectionProgress done_;
  std::optional<Error> error_;  // The first.
};

Result<std::vector<Group>> OpenGroups(std::span<const ObjectModel> models,
                                      const DetectionRequest& request) {
  std::vector<Group> groups;
  for (size_t model = 0; model < models.size(); ++model) {
    for (const SequenceKind kind : {SequenceKind::kCircle, SequenceKind::kRandom}) {
      const int count = kind == SequenceKind::kCircle ? request.circles : request.random_sequences;
      if (count == 0) continue;
      Result<DetectionCache> cache =
          DetectionCache::Open(request.cache,
                               {models[model].id,
                                kind,
                                request.simulation.views.NumViews(kind),
                                DetectionKey(models[model], kind, request.simulation)});
      if (!cache) return cache.error();
      groups.push_back({model, kind, count, std::move(cache).value(), {}});
    }
  }
  return groups;
}

Result<void> CheckDistinct(std::span<const ObjectModel> models) {
  std::set<std::string> ids;
  for (const ObjectModel& model : models) {
    if (ids.insert(model.id).second) continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("model \"%s\" is given twice, expected each once", model.id.c_str())};
  }
  return {};
}

}  // namespace

Result<void> DetectionRequest::Validate() const {
  if (Result<void> valid = simulation.Validate(); !valid) return valid;
  constexpr int kMostSequences = 100'000;
  constexpr int kMostThreads = 256;
  const auto check = [](const char* name, int value, int lowest, int highest) -> Result<void> {
    if (value >= lowest && value <= highest) return {};
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s = %d, expected %d to %d", name, value, lowest, highest)};
  };
  for (const Result<void>& valid : {check("circles", circles, 0, kMostSequences),
                                    check("random sequences", random_sequences, 0, kMostSequences),
                                    check("threads", threads, 1, kMostThreads)}) {
    if (!valid) return valid;
  }
  return {};
}

Result<DetectionRun> RunDetections(std::span<const ObjectModel> models,
                                   const DetectionRequest& request,
                                   const std::stop_token& stop,
                                   const std::function<void(const DetectionProgress&)>& progress) {
  for (const Result<void>& valid : {request.Validate(), CheckDistinct(models)}) {
    if (!valid) return valid.error();
  }
  Result<std::vector<Group>> groups = OpenGroups(models, request);
  if (!groups) return groups.error();
  DetectionRun run;
  Work work(models, request, std::move(groups).value(), progress);
  if (Result<void> done = work.Run(stop); !done) return done.error();

  run.is_complete = true;
  run.views_made = work.views_made();
  run.views_reused = -run.views_made;
  for (const ObjectModel& model : models) run.models.push_back({model.id, {}, {}});
  for (const Group& group : work.groups()) {
    const int count = std::min(group.count, group.num_present());
    run.is_complete = run.is_complete && count == group.count;
    run.views_reused += static_cast<int64_t>(count) * work.NumViews(group);
    if (!group.cache.note().empty()) run.notes.push_back(group.cache.note());
    ModelDetections& model = run.models[group.model];
    const std::vector<DetectionSequence>& all = group.cache.sequences();
    (group.kind == SequenceKind::kCircle ? model.circles : model.random)
        .assign(all.begin(), all.begin() + count);
  }
  return run;
}

}  // namespace vantage
