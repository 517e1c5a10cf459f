#include "tools/contingency/measure_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "common/check.h"
#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confusion/viewing_direction.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

// Trials of different kinds share no seeds. A direction at one roll has a kind of its own.
enum class TrialKind : uint64_t { kDirection = 1, kRow = 2, kDirectionAtRoll = 3 };

uint64_t UnitSeed(const TrialPlan& plan, TrialKind kind, int32_t unit) {
  uint64_t seed = MixBits(plan.seed);
  seed = MixBits(seed ^ Fnv1a(plan.model_id));
  seed = MixBits(seed ^ static_cast<uint64_t>(kind));
  return MixBits(seed ^ static_cast<uint64_t>(unit));
}

// Draws truths and lets them be detected.
// @param draw makes q_camera_object of a trial.
// @param take takes the truth and what was detected, and says whether to go on.
template <class Draw, class Take>
void RunTrials(uint64_t unit_seed,
               const TrialDetector& detect,
               const Draw& draw,
               const Take& take) {
  bool goes_on = true;
  for (uint64_t trial = 0; goes_on; ++trial) {
    const uint64_t seed = MixBits(unit_seed ^ trial);
    Rng rng(seed);
    const Eigen::Quaterniond q_camera_object = draw(rng);
    goes_on = take(q_camera_object, detect(q_camera_object, MixBits(seed)));
  }
}

// Hands units to threads and takes them back into the file.
class Work {
 public:
  using Outcome = std::variant<DirectionTrials, RowTrials>;
  struct Unit {
    bool is_row = false;
    int32_t index = 0;
  };

  Work(const TrialPlan& plan,
       const TrialUnits& units,
       const TrialDetectorFactory& make_detector,
       const std::function<void(const MeasureProgress&)>& progress,
       WorkFile* work)
      : plan_(plan), make_detector_(make_detector), progress_(progress), file_(work) {
    const ContingencyTable& table = work->table();
    if (table.key.num_directions > 0) directions_.emplace(table.key.num_directions);
    if (!units.rows.empty()) rows_.emplace(table.key.rows_k);
    for (const int32_t direction : units.directions) {
      if (table.directions[static_cast<size_t>(direction)].trials == 0) {
        units_.push_back({false, direction});
      }
    }
    for (const int32_t row : units.rows) {
      if (!table.rows.contains(row)) units_.push_back({true, row});
    }
    done_.units_total = static_cast<int64_t>(units.size());
    done_.units_done = done_.units_total - static_cast<int64_t>(units_.size());
  }

  Result<bool> Run(int num_threads, const std::stop_token& stop) {
    if (progress_) progress_(done_);
    {
      std::vector<std::jthread> threads;
      const size_t count = std::min(units_.size(), static_cast<size_t>(num_threads));
      for (size_t i = 0; i < count; ++i) {
        threads.emplace_back([this, &stop] { RunThread(stop); });
      }
    }
    if (error_) return *error_;
    return done_.units_done == done_.units_total;
  }

 private:
  void RunThread(const std::stop_token& stop) {
    const Result<TrialDetector> detector = make_detector_();
    if (!detector) return Fail(detector.error());
    while (const std::optional<Unit> unit = Next(stop)) {
      if (unit->is_row) {
        Finish(*unit, MeasureRow(plan_, *rows_, unit->index, *detector));
      } else {
        Finish(*unit, MeasureDirection(plan_, *directions_, unit->index, std::nullopt, *detector));
      }
    }
  }

  std::optional<Unit> Next(const std::stop_token& stop) {
    const std::lock_guard lock(mutex_);
    if (stop.stop_requested() || error_ || next_ == units_.size()) return std::nullopt;
    return units_[next_++];
  }

  void Finish(const Unit& unit, Outcome outcome) {
    const std::lock_guard lock(mutex_);
    if (error_) return;
    const Result<void> appended =
        unit.is_row
            ? file_->AppendRow(unit.index, std::get<RowTrials>(std::move(outcome)))
            : file_->AppendDirection(unit.index, std::get<DirectionTrials>(std::move(outcome)));
    if (!appended) {
      error_ = appended.error();
      return;
    }
    ++done_.units_done;
    if (progress_) progress_(done_);
  }

  void Fail(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = error;
  }

  const TrialPlan& plan_;
  const TrialDetectorFactory& make_detector_;
  const std::function<void(const MeasureProgress&)>& progress_;
  std::optional<DirectionGrid> directions_;
  std::optional<So3Grid> rows_;
  std::vector<Unit> units_;
  std::mutex mutex_;
  WorkFile* file_;   // Guarded, as what follows.
  size_t next_ = 0;  // Of units_.
  MeasureProgress done_;
  std::optional<Error> error_;  // The first.
};

}  // namespace

DirectionTrials MeasureDirection(const TrialPlan& plan,
                                 const DirectionGrid& grid,
                                 int direction,
                                 std::optional<double> roll,
                                 const TrialDetector& detect) {
  uint64_t seed =
      UnitSeed(plan, roll ? TrialKind::kDirectionAtRoll : TrialKind::kDirection, direction);
  if (roll) seed = MixBits(seed ^ static_cast<uint64_t>(std::lround(*roll / kDegree * 1000.0)));
  const auto draw = [&](Rng& rng) {
    const Eigen::Vector3d seen_from = grid.Sample(direction, rng);
    const double any_roll = rng.Uniform(0.0, 2.0 * M_PI);
    return OrientationSeenFrom(seen_from, roll.value_or(any_roll));
  };
  StoppingRule rule(plan.stopping, plan.symmetry);
  DirectionTrials trials;
  std::map<std::array<int16_t, 3>, int32_t> counts;
  RunTrials(seed, detect, draw, [&](const Eigen::Quaterniond& truth, const auto& detected) {
    ++trials.trials;
    std::optional<Eigen::Quaterniond> difference;
    if (detected) difference = truth.conjugate() * *detected;
    if (difference) ++counts[DifferenceCount::StepsOf(*difference)];
    if (!difference) ++trials.missed;
    rule.Add(difference);
    return !rule.IsDone();
  });
  for (const auto& [steps, count] : counts) trials.differences.push_back({steps, count});
  return trials;
}

RowTrials MeasureRow(const TrialPlan& plan,
                     const So3Grid& grid,
                     int32_t ordinal,
                     const TrialDetector& detect) {
  std::vector<So3Grid::Cell> cell;
  grid.CellsAt(ordinal, 1, &cell);
  const Eigen::Quaterniond q_truth = grid.Representative(cell.front());
  const uint64_t seed = UnitSeed(plan, TrialKind::kRow, ordinal);
  const auto draw = [&](Rng&) { return q_truth; };
  RowTrials trials;
  std::map<int32_t, int32_t> counts;
  RunTrials(seed, detect, draw, [&](const Eigen::Quaterniond&, const auto& detected) {
    ++trials.trials;
    if (detected) ++counts[grid.Ordinal(grid.CellOf(*detected))];
    if (!detected) ++trials.missed;
    return trials.trials < plan.stopping.most_trials;
  });
  for (const auto& [cell_detected, count] : counts) {
    trials.detected.push_back({cell_detected, count});
  }
  return trials;
}

Result<bool> MeasureTable(const TrialPlan& plan,
                          const TrialUnits& units,
                          int threads,
                          const TrialDetectorFactory& make_detector,
                          const std::stop_token& stop,
                          const std::function<void(const MeasureProgress&)>& progress,
                          WorkFile* work) {
  VANTAGE_CHECK(threads >= 1, "threads");
  return Work(plan, units, make_detector, progress, work).Run(threads, stop);
}

}  // namespace vantage
