#include "tools/evaluate/confusion_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <thread>
#include <utility>

#include "common/format.h"
#include "fusion/confusion/mode_belief.h"
#include "fusion/orientation_filter.h"
#include "fusion/so3_grid.h"
#include "tools/evaluate/confusion_view_cache.h"
#include "tools/evaluate/detection_key.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr uint64_t kSeedOffset = 0x636f6e667573ULL;  // Not the sequences of the paper's evaluation.
constexpr int kHistogramK = 32;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Streams of one sequence's random numbers.
enum Stream : uint64_t { kPose = 1, kFirstView, kStrategy };

Eigen::Quaterniond Rotation(const Pose& pose) {
  return Eigen::Quaterniond(pose.linear()).normalized();
}

// All that one sequence has, whichever way it goes.
struct Sequence {
  int index = 0;
  uint64_t seed = 0;
  SimulatedViews placed;
  std::vector<Pose> candidates;
  int first = 0;  // Candidate.
};

Sequence MakeSequence(const ObjectModel& model,
                      int index,
                      const ConfusionViewsParameters& parameters) {
  Sequence sequence;
  sequence.index = index;
  const SimulationParameters& simulation = parameters.simulation;
  sequence.seed =
      MixBits(SequenceSeed(simulation.seed, model.id, SequenceKind::kRandom, index) + kSeedOffset);
  Rng pose_rng(sequence.seed, kPose);
  sequence.placed = MakeSimulatedViews(model,
                                       SequenceKind::kRandom,
                                       index,
                                       simulation.views,
                                       simulation.camera,
                                       simulation.sensor.nearest,
                                       pose_rng);
  const Eigen::Vector3d target = sequence.placed.T_world_object * model.center;
  sequence.candidates =
      BandOfViews(target, sequence.placed.scale * parameters.distance, parameters);
  Rng first_rng(sequence.seed, kFirstView);
  sequence.first =
      static_cast<int>(first_rng.Below(static_cast<uint32_t>(sequence.candidates.size())));
  return sequence;
}

// Simulated views of one object, made when they are not in the cache.
class Looker {
 public:
  Looker(SequenceSimulator* simulator, ConfusionViewCache* cache)
      : simulator_(simulator), cache_(cache) {}

  void Begin(const Sequence& sequence) {
    sequence_ = &sequence;
    stage_.reset();
  }

  Result<SeenOrientation> Look(int candidate, int step) {
    const Pose& T_world_camera = sequence_->candidates[static_cast<size_t>(candidate)];
    const SeenFrom from{sequence_->index, step, T_world_camera};
    if (const auto seen = cache_->Find(from)) {
      ++reused_;
      return *seen;
    }
    if (!stage_) stage_.emplace(simulator_->Place(sequence_->placed, sequence_->seed));
    const DetectedView view = simulator_->Look(T_world_camera, step, &*stage_);
    SeenOrientation seen;
    if (!view.detections.empty()) {
      const Detection& best = view.detections.front();
      seen.q_world_object = Canonical(Rotation(T_world_camera * best.T_camera_object));
      seen.mse = best.mse;
    }
    ++made_;
    if (Result<void> kept = cache_->Keep(from, seen); !kept) return kept.error();
    return seen;
  }

  [[nodiscard]] int64_t made() const { return made_; }
  [[nodiscard]] int64_t reused() const { return reused_; }

 private:
  SequenceSimulator* simulator_;
  ConfusionViewCache* cache_;
  const Sequence* sequence_ = nullptr;
  std::optional<SimulatedStage> stage_;
  int64_t made_ = 0;
  int64_t reused_ = 0;
};

// One strategy on one sequence: the belief, the fused orientation and where to look next.
class Walk {
 public:
  Walk(const ConfusedObject& object,
       const Sequence& sequence,
       const ConfusionViewsParameters& parameters,
       const So3Grid& grid)
      : object_(object),
        sequence_(sequence),
        parameters_(parameters),
        filter_(grid, {}, {{}, object.model->symmetry, object.confusion}),
        taken_(sequence.candidates.size(), false) {}

  ConfusionStep Add(int candidate, const SeenOrientation& seen) {
    const Pose& T_world_camera = sequence_.candidates[static_cast<size_t>(candidate)];
    taken_[static_cast<size_t>(candidate)] = true;
    visited_.push_back(T_world_camera);
    views_.push_back({Rotation(T_world_camera), seen.q_world_object});
    belief_ = ModeBelief(*object_.confusion, views_);
    // A detection that is not valid does not come out of the simulator.
    if (seen.q_world_object) {
      static_cast<void>(
          filter_.Add({*seen.q_world_object, seen.mse, Rotation(T_world_camera)}).ok());
    }
    ConfusionStep step;
    step.candidate = candidate;
    step.found = seen.q_world_object.has_value();
    step.detection_deg = step.found ? ErrorDeg(*seen.q_world_object) : kNone;
    const Result<Eigen::Quaterniond> fused = filter_.Estimate();
    step.final_deg = fused ? ErrorDeg(*fused) : kNone;
    for (const OrientationHypothesis& one : belief_) {
      if (IsRight(one)) step.right_mass += one.probability;
    }
    if (!belief_.empty()) {
      step.best_mass = belief_.front().probability;
      step.is_best_right = IsRight(belief_.front());
    }
    return step;
  }

  int Next(const ViewCriterion& criterion) const {
    PlannedObject planned;
    planned.model_id = object_.model->id;
    planned.center_world = sequence_.placed.T_world_object * object_.model->center;
    planned.radius = 0.5 * object_.model->diameter;
    planned.confusion = object_.confusion;
    planned.belief = belief_;
    if (!belief_.empty()) {
      planned.T_world_object.linear() = belief_.front().q_world_object.toRotationMatrix();
    }
    PlanningState state;
    state.candidates = sequence_.candidates;
    state.visited = visited_;
    state.objects = {&planned, 1};
    state.target = planned.center_world;
    return ChooseView(criterion, state, taken_);
  }

 private:
  [[nodiscard]] double ErrorDeg(const Eigen::Quaterniond& q_world_object) const {
    return SymmetricAngle(
               object_.model->symmetry, q_world_object, Rotation(sequence_.placed.T_world_object)) /
           kDegree;
  }
  [[nodiscard]] bool IsRight(const OrientationHypothesis& one) const {
    return ErrorDeg(one.q_world_object) <= parameters_.right_angle;
  }

  const ConfusedObject& object_;
  const Sequence& sequence_;
  const ConfusionViewsParameters& parameters_;
  OrientationFilter filter_;
  std::vector<bool> taken_;
  std::vector<Pose> visited_;
  std::vector<ConfusionView> views_;
  std::vector<OrientationHypothesis> belief_;
};

// Hands sequences to threads and takes them back.
class Work {
 public:
  Work(std::span<const ConfusedObject> objects,
       std::span<const ConfusionStrategy> strategies,
       const ConfusionViewsParameters& parameters,
       const std::function<void(int64_t, int64_t)>& progress)
      : objects_(objects), strategies_(strategies), parameters_(parameters), progress_(progress) {
    result_.runs.assign(
        objects.size(),
        std::vector<StrategyRuns>(strategies.size(),
                                  StrategyRuns(static_cast<size_t>(parameters.sequences))));
  }

  Result<ConfusionViews> Run(const std::stop_token& stop) {
    for (const ConfusedObject& object : objects_) {
      const std::string key =
          DetectionKey(*object.model, SequenceKind::kRandom, parameters_.simulation) +
          "one view at a time, version 1\n";
      auto cache = ConfusionViewCache::Open(parameters_.cache, object.model->id, key);
      if (!cache) return cache.error();
      caches_.push_back(std::move(cache).value());
      if (!caches_.back()->note().empty()) result_.notes.push_back(caches_.back()->note());
    }
    {
      std::vector<std::jthread> threads;
      const auto count = std::min(NumTasks(), static_cast<size_t>(parameters_.threads));
      for (size_t i = 0; i < count; ++i) {
        threads.emplace_back([this, &stop] { RunThread(stop); });
      }
    }
    if (error_) return *error_;
    result_.is_complete = done_ == NumTasks();
    return std::move(result_);
  }

 private:
  [[nodiscard]] size_t NumTasks() const {
    return objects_.size() * static_cast<size_t>(parameters_.sequences);
  }

  void RunThread(const std::stop_token& stop) {
    std::unique_ptr<SequenceSimulator> simulator;
    std::optional<size_t> simulated;  // Object.
    while (const std::optional<size_t> task = Next(stop)) {
      const size_t object = *task / static_cast<size_t>(parameters_.sequences);
      if (simulated != object) {
        simulator.reset();  // Its tables go before others come.
        auto created = SequenceSimulator::Create(*objects_[object].model, parameters_.simulation);
        if (!created) return Fail(created.error());
        simulator = std::move(created).value();
        simulated = object;
      }
      const auto index = *task % static_cast<size_t>(parameters_.sequences);
      Looker looker(simulator.get(), caches_[object].get());
      if (Result<void> walked = RunSequence(object, index, &looker); !walked) {
        return Fail(walked.error());
      }
      Finish(looker);
    }
  }

  Result<void> RunSequence(size_t object, size_t index, Looker* looker) {
    const ConfusedObject& confused = objects_[object];
    const Sequence sequence = MakeSequence(*confused.model, static_cast<int>(index), parameters_);
    looker->Begin(sequence);
    for (size_t s = 0; s < strategies_.size(); ++s) {
      const ViewCriterion criterion = strategies_[s].make(
          confused.model->id, *confused.confusion, MixBits(sequence.seed + kStrategy));
      Walk walk(confused, sequence, parameters_, grid_);
      std::vector<ConfusionStep>& steps = result_.runs[object][s][index];
      int candidate = sequence.first;
      for (int step = 0; step < parameters_.views && candidate >= 0; ++step) {
        const Result<SeenOrientation> seen = looker->Look(candidate, step);
        if (!seen) return seen.error();
        steps.push_back(walk.Add(candidate, *seen));
        if (step + 1 < parameters_.views) candidate = walk.Next(criterion);
      }
    }
    return {};
  }

  std::optional<size_t> Next(const std::stop_token& stop) {
    const std::lock_guard lock(mutex_);
    if (next_ == 0 && progress_) progress_(0, static_cast<int64_t>(NumTasks()));
    if (stop.stop_requested() || error_ || next_ == NumTasks()) return std::nullopt;
    return next_++;
  }

  void Finish(const Looker& looker) {
    const std::lock_guard lock(mutex_);
    ++done_;
    result_.views_made += looker.made();
    result_.views_reused += looker.reused();
    if (progress_) progress_(static_cast<int64_t>(done_), static_cast<int64_t>(NumTasks()));
  }

  void Fail(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = error;
  }

  std::span<const ConfusedObject> objects_;
  std::span<const ConfusionStrategy> strategies_;
  const ConfusionViewsParameters& parameters_;
  const std::function<void(int64_t, int64_t)>& progress_;
  So3Grid grid_{kHistogramK};
  std::vector<std::unique_ptr<ConfusionViewCache>> caches_;
  ConfusionViews result_;  // Runs are each one thread's own; the rest is guarded.
  std::mutex mutex_;
  size_t next_ = 0;
  size_t done_ = 0;
  std::optional<Error> error_;  // The first.
};

}  // namespace

Result<void> ConfusionViewsParameters::Validate() const {
  if (Result<void> valid = simulation.Validate(); !valid) return valid;
  struct Bound {
    const char* name;
    double value, lowest, highest;
  };
  const Bound bounds[] = {
      {"sequences", static_cast<double>(sequences), 1.0, 100'000.0},
      {"views", static_cast<double>(views), 1.0, static_cast<double>(candidates)},
      {"candidates", static_cast<double>(candidates), 1.0, 100'000.0},
      {"lowest_elevation_deg", lowest_elevation_deg, 5.0, 90.0},
      {"highest_elevation_deg", highest_elevation_deg, lowest_elevation_deg, 90.0},
      {"distance", distance, 0.1, 10.0},
      {"right_angle", right_angle, 0.0, 180.0},
      {"threads", static_cast<double>(threads), 1.0, 1024.0},
  };
  for (const Bound& bound : bounds) {
    if (bound.value >= bound.lowest && bound.value <= bound.highest) continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("views to the right mode: %s = %g, expected %g to %g",
                        bound.name,
                        bound.value,
                        bound.lowest,
                        bound.highest)};
  }
  return {};
}

std::vector<Pose> BandOfViews(const Eigen::Vector3d& target,
                              double distance,
                              const ConfusionViewsParameters& parameters) {
  const double lowest = std::sin(parameters.lowest_elevation_deg * kDegree);
  const double highest = std::sin(parameters.highest_elevation_deg * kDegree);
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Pose> poses;
  for (int i = 0; i < parameters.candidates; ++i) {
    const double z = lowest + (highest - lowest) * (i + 0.5) / parameters.candidates;
    const double radius = std::sqrt(1.0 - z * z);
    const double azimuth = golden_angle * i;
    const Eigen::Vector3d direction(radius * std::cos(azimuth), radius * std::sin(azimuth), z);
    poses.push_back(LookAt(target + distance * direction, target));
  }
  return poses;
}

Result<ConfusionViews> RunConfusionViews(std::span<const ConfusedObject> objects,
                                         std::span<const ConfusionStrategy> strategies,
                                         const ConfusionViewsParameters& parameters,
                                         const std::stop_token& stop,
                                         const std::function<void(int64_t, int64_t)>& progress) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  return Work(objects, strategies, parameters, progress).Run(stop);
}

}  // namespace vantage
