#include "tools/contingency/left_invariance.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "common/rng.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/confusion/held_out.h"
#include "fusion/confusion/predicted_row.h"
#include "fusion/confusion/trial_count.h"
#include "fusion/confusion/two_sample_test.h"
#include "fusion/confusion/viewing_direction.h"
#include "fusion/so3_grid.h"
#include "tools/contingency/trial_units.h"

namespace vantage {
namespace {

constexpr uint64_t kTestStream = 29;     // Of random numbers, apart from those of trials.
constexpr uint64_t kHeldOutSeed = 1000;  // Added to the table's.

// Measured samples, each made by one thread.
struct Samples {
  std::vector<std::vector<DirectionTrials>> by_direction;  // Random rolls, then each roll.
  std::vector<RowTrials> rows, held_out;
};

using Job = std::function<void(const TrialDetector&)>;

// False after a stop.
Result<bool> RunJobs(const std::vector<Job>& jobs,
                     int num_threads,
                     const TrialDetectorFactory& make_detector,
                     const std::stop_token& stop,
                     const std::function<void(int64_t, int64_t)>& progress) {
  std::mutex mutex;
  size_t next = 0;
  size_t done = 0;
  std::optional<Error> error;
  const auto run = [&] {
    const Result<TrialDetector> detector = make_detector();
    while (true) {
      size_t job = 0;
      {
        const std::lock_guard lock(mutex);
        if (!detector && !error) error = detector.error();
        if (error || stop.stop_requested() || next == jobs.size()) return;
        job = next++;
      }
      jobs[job](*detector);
      const std::lock_guard lock(mutex);
      ++done;
      if (progress) progress(static_cast<int64_t>(done), static_cast<int64_t>(jobs.size()));
    }
  };
  {
    std::vector<std::jthread> threads;
    const size_t count = std::min(jobs.size(), static_cast<size_t>(num_threads));
    for (size_t i = 0; i < count; ++i) threads.emplace_back(run);
  }
  if (error) return *error;
  return done == jobs.size();
}

double RollOf(int index, int rolls) { return 2.0 * M_PI * index / rolls; }

class Test {
 public:
  Test(const ContingencyTable& table,
       const SymmetryGroup& symmetry,
       const LeftInvarianceParameters& parameters)
      : table_(table),
        parameters_(parameters),
        directions_(table.key.num_directions),
        grid_(LeftInvarianceParameters::kRowsK) {
    plan_ = {table.key.model_id, table.key.seed, symmetry, {}};
    plan_.stopping.least_trials = parameters.trials;
    plan_.stopping.most_trials = parameters.trials;
  }

  // Draws what is tested among what the table has. Errors: it has too little.
  Result<void> Draw() {
    std::vector<int32_t> measured;
    for (size_t i = 0; i < table_.directions.size(); ++i) {
      if (table_.directions[i].trials > 0) measured.push_back(static_cast<int32_t>(i));
    }
    if (measured.empty()) {
      return Error{ErrorCode::kInvalidArgument,
                   "the table has no trials by direction, expected some to test"};
    }
    const auto count = std::min(measured.size(), static_cast<size_t>(parameters_.directions));
    Rng rng(table_.key.seed, kTestStream);
    for (size_t i = 0; i < count; ++i) {
      std::swap(measured[i], measured[i + rng.Below(static_cast<uint32_t>(measured.size() - i))]);
    }
    tested_.assign(measured.begin(), measured.begin() + static_cast<std::ptrdiff_t>(count));
    std::sort(tested_.begin(), tested_.end());
    if (parameters_.rows == 0) return {};
    const Result<std::vector<int32_t>> rows =
        ParseRows(Format("random:%d", parameters_.rows), grid_.num_cells(), table_.key.seed);
    if (!rows) return rows.error();
    for (const int32_t row : *rows) {
      if (!DirectionOf(row).differences.empty()) rows_.push_back(row);
    }
    return {};
  }

  std::vector<Job> Jobs() {
    samples_.by_direction.resize(tested_.size());
    samples_.rows.resize(rows_.size());
    samples_.held_out.resize(rows_.size());
    std::vector<Job> jobs;
    for (size_t i = 0; i < tested_.size(); ++i) {
      samples_.by_direction[i].resize(static_cast<size_t>(parameters_.rolls) + 1);
      for (int roll = -1; roll < parameters_.rolls; ++roll) {
        jobs.emplace_back([this, i, roll](const TrialDetector& detect) {
          const std::optional<double> angle =
              roll < 0 ? std::nullopt : std::optional(RollOf(roll, parameters_.rolls));
          samples_.by_direction[i][static_cast<size_t>(roll + 1)] =
              MeasureDirection(plan_, directions_, tested_[i], angle, detect);
        });
      }
    }
    for (size_t i = 0; i < rows_.size(); ++i) {
      jobs.emplace_back([this, i](const TrialDetector& detect) {
        samples_.rows[i] = MeasureRow(plan_, grid_, rows_[i], detect);
        TrialPlan other = plan_;
        other.seed += kHeldOutSeed;
        samples_.held_out[i] = MeasureRow(other, grid_, rows_[i], detect);
      });
    }
    return jobs;
  }

  Result<LeftInvarianceReport> Report() {
    LeftInvarianceReport report;
    report.parameters = parameters_;
    if (Result<void> tested = TestRolls(&report); !tested) return tested.error();
    Predict(&report);
    report.paper_trials = NumTrials(grid_.num_cells());
    // Bonferroni and one side alone, as in eq. 11.
    const double alpha = 2.0 * 0.05 / grid_.num_cells();
    report.unseen = JeffreysInterval(0, report.paper_trials, alpha);
    report.unseen_in_samples = JeffreysInterval(0, parameters_.trials, alpha);
    return report;
  }

 private:
  [[nodiscard]] Eigen::Quaterniond Truth(int32_t row) const {
    std::vector<So3Grid::Cell> cell;
    grid_.CellsAt(row, 1, &cell);
    return grid_.Representative(cell.front());
  }
  [[nodiscard]] const DirectionTrials& DirectionOf(int32_t row) const {
    const int direction = directions_.CellOf(ViewingDirection(Truth(row)));
    return table_.directions[static_cast<size_t>(direction)];
  }

  Result<void> TestRolls(LeftInvarianceReport* report) {
    // The least p, 1 / (permutations + 1), is half of what Holm's first step rejects.
    const auto num_tests = static_cast<double>(tested_.size()) * parameters_.rolls;
    report->permutations =
        std::max(999, static_cast<int>(std::ceil(2.0 * num_tests / parameters_.alpha)));
    std::vector<double> all;
    std::vector<double> of_first;
    for (size_t i = 0; i < tested_.size(); ++i) {
      const auto reference = OutcomesOf(samples_.by_direction[i].front());
      if (!reference) return reference.error();
      for (int roll = 0; roll < parameters_.rolls; ++roll) {
        const auto at_roll = OutcomesOf(samples_.by_direction[i][static_cast<size_t>(roll) + 1]);
        if (!at_roll) return at_roll.error();
        Rng rng(table_.key.seed, kTestStream + 1 + all.size());
        const auto tested = EnergyTest(*at_roll, *reference, report->permutations, rng);
        if (!tested) return tested.error();
        report->tests.push_back({tested_[i],
                                 RollOf(roll, parameters_.rolls) / kDegree,
                                 tested->statistic,
                                 tested->p_value});
        all.push_back(tested->p_value);
        if (roll == 0) of_first.push_back(tested->p_value);
      }
    }
    report->all = Combine(all, parameters_.alpha);
    report->uniformity_p = UniformityTest(of_first);
    return {};
  }

  void Predict(LeftInvarianceReport* report) const {
    std::vector<RowTrials> predicted;
    for (const int32_t row : rows_) {
      predicted.push_back(PredictedRow(DirectionOf(row), grid_, Truth(row)));
    }
    report->num_rows = static_cast<int>(rows_.size());
    if (rows_.empty()) return;
    const int num_cells = grid_.num_cells();
    const double of_rows = LeaveOneOutPseudoCount(samples_.rows, num_cells);
    const double of_directions = LeaveOneOutPseudoCount(predicted, num_cells);
    std::vector<double> by_row;
    std::vector<double> by_direction;
    for (size_t i = 0; i < rows_.size(); ++i) {
      const RowTrials& held_out = samples_.held_out[i];
      by_row.push_back(HeldOutLogLikelihood(samples_.rows[i], held_out, num_cells, of_rows));
      by_direction.push_back(
          HeldOutLogLikelihood(predicted[i], held_out, num_cells, of_directions));
    }
    report->rows_log_likelihood = Mean(by_row);
    report->directions_log_likelihood = Mean(by_direction);
    Rng rng(table_.key.seed, kTestStream);
    report->difference = PairedDifferenceInterval(by_direction, by_row, Statistic::kMean, {}, rng);
  }

  const ContingencyTable& table_;
  const LeftInvarianceParameters& parameters_;
  DirectionGrid directions_;
  So3Grid grid_;
  TrialPlan plan_;
  std::vector<int32_t> tested_, rows_;
  Samples samples_;
};

}  // namespace

Result<std::optional<LeftInvarianceReport>> TestLeftInvariance(
    const ContingencyTable& table,
    const SymmetryGroup& symmetry,
    const LeftInvarianceParameters& parameters,
    int threads,
    const TrialDetectorFactory& make_detector,
    const std::stop_token& stop,
    const std::function<void(int64_t, int64_t)>& progress) {
  VANTAGE_CHECK(threads >= 1 && parameters.rolls >= 1 && parameters.trials >= 2, "test");
  if (table.key.num_directions == 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "the table has rows alone, expected trials by direction to test"};
  }
  Test test(table, symmetry, parameters);
  if (Result<void> drawn = test.Draw(); !drawn) return drawn.error();
  const Result<bool> done = RunJobs(test.Jobs(), threads, make_detector, stop, progress);
  if (!done) return done.error();
  if (!*done) return std::optional<LeftInvarianceReport>();
  Result<LeftInvarianceReport> report = test.Report();
  if (!report) return report.error();
  return std::optional(std::move(report).value());
}

std::string ReportText(const LeftInvarianceReport& report) {
  const LeftInvarianceParameters& parameters = report.parameters;
  std::string text =
      Format("Left invariance: %zu tests of %d trials at one roll against %d at random rolls\n",
             report.tests.size(),
             parameters.trials,
             parameters.trials);
  text += Format(
      "  %d below %.0f %%, %.1f expected where nothing differs; %d after Holm's "
      "correction, whose smallest p is %.3f\n",
      report.all.num_rejected,
      100.0 * parameters.alpha,
      report.all.expected_rejected,
      report.all.num_rejected_by_holm,
      report.all.smallest_p);
  text += Format("  p values of the first roll uniform: p = %.3f\n", report.uniformity_p);
  text += report.all.num_rejected_by_holm == 0
              ? "  The rolls do not differ: the table by direction holds at every roll.\n"
              : "  The rolls differ: the table by direction is an average over rolls.\n";
  text += "  direction  roll, deg   statistic       p\n";
  for (const RollTest& test : report.tests) {
    text += Format(
        "  %9d %10.1f %11.4f %7.3f\n", test.direction, test.roll_deg, test.statistic, test.p_value);
  }
  if (report.num_rows > 0) {
    text += Format("Held-out trials of %d rows of k = %d: mean log probability\n",
                   report.num_rows,
                   LeftInvarianceParameters::kRowsK);
    text +=
        Format("  %.3f by rows of %d trials, %.3f by directions: %+.3f (95 %%: %+.3f to %+.3f)\n",
               report.rows_log_likelihood,
               parameters.trials,
               report.directions_log_likelihood,
               report.difference.value,
               report.difference.low,
               report.difference.high);
  }
  text += Format(
      "Eq. 11: %d trials a row; what was never seen in them has a share of at most "
      "%.1f %%, in %d trials of %.1f %%\n",
      report.paper_trials,
      100.0 * report.unseen.high,
      parameters.trials,
      100.0 * report.unseen_in_samples.high);
  return text;
}

std::string ReportJson(const LeftInvarianceReport& report) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["trials_per_sample"] = report.parameters.trials;
  json["permutations"] = report.permutations;
  json["alpha"] = report.parameters.alpha;
  json["num_tests"] = report.all.num_tests;
  json["num_rejected"] = report.all.num_rejected;
  json["expected_rejected"] = report.all.expected_rejected;
  json["num_rejected_by_holm"] = report.all.num_rejected_by_holm;
  json["smallest_p_by_holm"] = report.all.smallest_p;
  json["uniformity_p"] = report.uniformity_p;
  for (const RollTest& test : report.tests) {
    json["tests"].push_back({{"direction", test.direction},
                             {"roll_deg", test.roll_deg},
                             {"statistic", test.statistic},
                             {"p", test.p_value}});
  }
  json["rows"] = report.num_rows;
  json["rows_log_likelihood"] = report.rows_log_likelihood;
  json["directions_log_likelihood"] = report.directions_log_likelihood;
  json["difference"] = {report.difference.value, report.difference.low, report.difference.high};
  json["eq11_trials"] = report.paper_trials;
  json["unseen_share_at_most"] = report.unseen.high;
  json["unseen_share_in_samples_at_most"] = report.unseen_in_samples.high;
  return json.dump(2) + "\n";
}

}  // namespace vantage
