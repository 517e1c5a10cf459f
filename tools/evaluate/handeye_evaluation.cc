#include "tools/evaluate/handeye_evaluation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <span>

#include "common/format.h"
#include "perception/calibration/pose_calibration.h"
#include "tools/evaluate/handeye_methods.h"
#include "tools/evaluate/handeye_simulation.h"

namespace vantage {
namespace {

constexpr const char* kOurs = "Vantage";
constexpr int kPeerShare = 5;
constexpr HandEyeSetup kSetups[] = {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand};
constexpr int kViews[] = {20, 30, 50};
constexpr double kOutlierShares[] = {0.0, 0.1, 0.3};
constexpr int kBarViews = 30;

struct NamedMotion {
  HandEyeMotion motion;
  const char* name;
};
constexpr NamedMotion kDegenerate[] = {{HandEyeMotion::kOneAxis, "about one axis"},
                                       {HandEyeMotion::kWobble, "about one axis, 0.2° wobble"},
                                       {HandEyeMotion::kNoTurn, "no rotation"},
                                       {HandEyeMotion::kSamePose, "same pose"}};

const char* NameOf(HandEyeSetup setup) {
  return setup == HandEyeSetup::kEyeInHand ? "eye in hand" : "eye to hand";
}

/// What a method did in the trials of a cell.
struct Samples {
  std::vector<double> translation_mm;
  std::vector<double> rotation_deg;
  std::vector<double> ms;
  double bound_translation = 0.0;  ///< mm^2, sum over the trials with a result
  double bound_rotation = 0.0;     ///< deg^2
  int failed = 0;
};

/// Of this thread's own work: what else the machine does doesn't count.
class Stopwatch {
 public:
  [[nodiscard]] double Milliseconds() const { return Now() - start_; }

 private:
  static double Now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
  }

  double start_ = Now();
};

void AddError(const Pose& T_x,
              const SimulatedHandEye& truth,
              const HandEyeCovariance& bound,
              Samples* samples) {
  const Eigen::Matrix<double, 6, 1> error = HandEyeError(T_x, truth.T_x);
  samples->rotation_deg.push_back(error.head<3>().norm() / kDegree);
  samples->translation_mm.push_back(1e3 * error.tail<3>().norm());
  samples->bound_rotation += bound.topLeftCorner<3, 3>().trace() / (kDegree * kDegree);
  samples->bound_translation += 1e6 * bound.bottomRightCorner<3, 3>().trace();
}

Interval Mapped(const Interval& interval, double (*map)(double)) {
  return {map(interval.value), map(interval.low), map(interval.high)};
}

Interval Divided(const Interval& interval, double by) {
  return {interval.value / by, interval.low / by, interval.high / by};
}

Interval RootMeanSquare(std::span<const double> values, Rng& rng) {
  std::vector<double> squares;
  for (const double value : values) squares.push_back(value * value);
  return Mapped(BootstrapInterval(squares, Statistic::kMean, {}, rng),
                [](double value) { return std::sqrt(value); });
}

void Summarize(const Samples& samples, HandEyeCell* cell, Rng& rng) {
  cell->failed = samples.failed;
  cell->median_mm = BootstrapInterval(samples.translation_mm, Statistic::kMedian, {}, rng);
  cell->median_deg = BootstrapInterval(samples.rotation_deg, Statistic::kMedian, {}, rng);
  cell->rmse_mm = RootMeanSquare(samples.translation_mm, rng);
  cell->rmse_deg = RootMeanSquare(samples.rotation_deg, rng);
  const double count = static_cast<double>(samples.translation_mm.size());
  cell->ratio_translation = Divided(cell->rmse_mm, std::sqrt(samples.bound_translation / count));
  cell->ratio_rotation = Divided(cell->rmse_deg, std::sqrt(samples.bound_rotation / count));
  cell->median_ms = Median(samples.ms);
  cell->least_ms =
      samples.ms.empty() ? 0.0 : *std::min_element(samples.ms.begin(), samples.ms.end());
}

/// A share and its 95 % interval by Wilson, "Probable Inference, the Law of Succession, and
/// Statistical Inference", 1927.
Interval ShareInterval(int count, int trials) {
  constexpr double kZ = 1.959964;
  const double n = trials;
  const double share = count / n;
  const double center = (share + kZ * kZ / (2.0 * n)) / (1.0 + kZ * kZ / n);
  const double half =
      kZ / (1.0 + kZ * kZ / n) * std::sqrt(share * (1.0 - share) / n + kZ * kZ / (4.0 * n * n));
  return {share, center - half, center + half};
}

/// Counts of ours in a cell.
struct SelfCounts {
  int covered = 0;
  int alarms = 0;
  int wrong_views = 0;
};

void RunOurs(const HandEyeSimulation& simulation,
             const SimulatedHandEye& made,
             const HandEyeCovariance& bound,
             Samples* samples,
             SelfCounts* counts) {
  PoseCalibrationOptions options;
  options.noise = simulation.noise;
  const Stopwatch stopwatch;
  const Result<HandEyeResult> result = CalibrateFromPoses(simulation.setup, made.views, options);
  samples->ms.push_back(stopwatch.Milliseconds());
  if (!result) {
    ++samples->failed;
    ++counts->alarms;
    return;
  }
  AddError(result->T_x, made, bound, samples);
  const Eigen::Matrix<double, 6, 1> error = HandEyeError(result->T_x, made.T_x);
  const double squared_radius = error.dot(result->covariance.ldlt().solve(error));
  counts->covered += squared_radius <= result->squared_radius_95 ? 1 : 0;
  counts->alarms += result->observability.is_sufficient ? 0 : 1;
  for (size_t i = 0; i < made.views.size(); ++i) {
    counts->wrong_views += result->views[i].is_outlier != made.is_outlier[i] ? 1 : 0;
  }
}

class Evaluation {
 public:
  Evaluation(const HandEyeRequest& request,
             const std::stop_token& stop,
             const std::function<void(int64_t, int64_t)>& progress,
             HandEyeResults* results)
      : request_(request), stop_(stop), progress_(progress), results_(*results) {
    results_.seed = request.seed;
    results_.trials = request.trials;
    results_.peer_trials = std::max(1, request.trials / kPeerShare);
    results_.methods = {kOurs};
    for (const HandEyeMethod& peer : peers_) results_.methods.push_back(peer.label);
    total_ = int64_t{request.trials} * std::ssize(kSetups) * std::ssize(kViews) *
                 std::ssize(kOutlierShares) +
             int64_t{results_.peer_trials} * std::ssize(kSetups) * std::ssize(kDegenerate) * 2;
  }

  bool Run() {
    for (const HandEyeSetup setup : kSetups) {
      for (const int views : kViews) {
        for (const double share : kOutlierShares) {
          HandEyeSimulation simulation;
          simulation.setup = setup;
          simulation.views = views;
          simulation.outlier_share = share;
          if (!RunCell(simulation)) return false;
        }
      }
    }
    for (const HandEyeSetup setup : kSetups) {
      for (const NamedMotion& motion : kDegenerate) {
        for (const double share : {0.0, 0.3}) {
          HandEyeSimulation simulation;
          simulation.setup = setup;
          simulation.motion = motion.motion;
          simulation.outlier_share = share;
          if (!RunDegenerate(simulation, motion.name)) return false;
        }
      }
    }
    return true;
  }

 private:
  /// False after a stop.
  bool Step() {
    progress_(++done_, total_);
    return !stop_.stop_requested();
  }

  Rng TrialRng(int trial) const { return Rng(request_.seed, static_cast<uint64_t>(trial)); }

  bool RunCell(const HandEyeSimulation& simulation) {
    std::vector<Samples> samples(1 + peers_.size());
    SelfCounts counts;
    for (int trial = 0; trial < request_.trials; ++trial) {
      Rng rng = TrialRng(trial);
      const SimulatedHandEye made = SimulateHandEye(simulation, rng);
      const HandEyeCovariance bound = HandEyeCramerRaoBound(made, simulation.noise);
      RunOurs(simulation, made, bound, &samples[0], &counts);
      for (size_t i = 0; trial < results_.peer_trials && i < peers_.size(); ++i) {
        const Stopwatch stopwatch;
        const auto T_x = peers_[i].calibrate(simulation.setup, made.views, simulation.noise);
        samples[i + 1].ms.push_back(stopwatch.Milliseconds());
        if (T_x) {
          AddError(*T_x, made, bound, &samples[i + 1]);
        } else {
          ++samples[i + 1].failed;
        }
      }
      if (!Step()) return false;
    }
    Rng rng(request_.seed);
    for (size_t i = 0; i < samples.size(); ++i) {
      HandEyeCell cell;
      cell.method = results_.methods[i];
      cell.setup = NameOf(simulation.setup);
      cell.views = simulation.views;
      cell.outlier_share = simulation.outlier_share;
      cell.trials = i == 0 ? results_.trials : results_.peer_trials;
      Summarize(samples[i], &cell, rng);
      results_.cells.push_back(cell);
    }
    results_.self_tests.push_back(
        {NameOf(simulation.setup),
         simulation.views,
         simulation.outlier_share,
         request_.trials,
         ShareInterval(counts.covered, request_.trials),
         ShareInterval(counts.alarms, request_.trials),
         static_cast<double>(counts.wrong_views) / (1.0 * request_.trials * simulation.views)});
    return true;
  }

  bool RunDegenerate(const HandEyeSimulation& simulation, const char* motion) {
    HandEyeDegenerate counted;
    counted.motion = motion;
    counted.setup = NameOf(simulation.setup);
    counted.outlier_share = simulation.outlier_share;
    counted.trials = results_.peer_trials;
    for (int trial = 0; trial < counted.trials; ++trial) {
      Rng rng = TrialRng(trial);
      const SimulatedHandEye made = SimulateHandEye(simulation, rng);
      const Result<HandEyeResult> result =
          CalibrateFromPoses(simulation.setup, made.views, PoseCalibrationOptions());
      counted.flagged += !result || !result->observability.is_sufficient ? 1 : 0;
      if (trial == 0) {
        counted.reason = result ? result->observability.reason : result.error().message;
      }
      if (!Step()) return false;
    }
    results_.degenerate.push_back(counted);
    return true;
  }

  const HandEyeRequest& request_;
  const std::stop_token& stop_;
  const std::function<void(int64_t, int64_t)>& progress_;
  HandEyeResults& results_;
  std::vector<HandEyeMethod> peers_ = HandEyePeers();
  int64_t done_ = 0;
  int64_t total_ = 0;
};

void AddBar(const std::string& name,
            double value,
            double low,
            double high,
            const char* unit,
            HandEyeResults* results) {
  results->bars.push_back({name, value, low, high, unit, value >= low && value <= high});
}

void JudgeBars(HandEyeResults* results) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  for (const HandEyeCell& cell : results->cells) {
    if (cell.method != kOurs || cell.views != kBarViews) continue;
    const std::string of = Format(", %s, %d views, %.0f %% outliers",
                                  cell.setup.c_str(),
                                  cell.views,
                                  100.0 * cell.outlier_share);
    if (cell.outlier_share == 0.0) {
      AddBar("translation by the Cramer-Rao bound" + of,
             cell.ratio_translation.value,
             kNone,
             1.05,
             "",
             results);
      AddBar("rotation by the Cramer-Rao bound" + of,
             cell.ratio_rotation.value,
             kNone,
             1.05,
             "",
             results);
    }
    if (cell.outlier_share == 0.3) {
      AddBar("median translation" + of, cell.median_mm.value, kNone, 0.5, "mm", results);
      AddBar("median rotation" + of, cell.median_deg.value, kNone, 0.05, "deg", results);
    }
    AddBar("time of a solve" + of, cell.median_ms, kNone, 20.0, "ms", results);
  }
  double alarms = 0.0;
  for (const HandEyeSelfTest& test : results->self_tests) {
    alarms += test.false_alarms.value / static_cast<double>(results->self_tests.size());
    if (test.views != kBarViews) continue;
    AddBar(Format("coverage of the 95 %% ellipsoid, %s, %d views, %.0f %% outliers",
                  test.setup.c_str(),
                  test.views,
                  100.0 * test.outlier_share),
           100.0 * test.coverage.value,
           93.0,
           97.0,
           "%",
           results);
  }
  int flagged = 0;
  int trials = 0;
  for (const HandEyeDegenerate& counted : results->degenerate) {
    flagged += counted.flagged;
    trials += counted.trials;
  }
  constexpr double kMost = std::numeric_limits<double>::infinity();
  AddBar("degenerate motions flagged",
         100.0 * flagged / std::max(1, trials),
         99.0,
         kMost,
         "%",
         results);
  AddBar("false alarms", 100.0 * alarms, kNone, 1.0, "%", results);
}

}  // namespace

bool EvaluateHandEye(const HandEyeRequest& request,
                     const std::stop_token& stop,
                     const std::function<void(int64_t done, int64_t total)>& progress,
                     HandEyeResults* results) {
  if (!Evaluation(request, stop, progress, results).Run()) return false;
  JudgeBars(results);
  return true;
}

std::vector<std::string> MissedBars(const HandEyeResults& results) {
  std::vector<std::string> missed;
  for (const HandEyeBar& bar : results.bars) {
    if (bar.met) continue;
    missed.push_back(Format("%s: %.3g %s, expected %s %g",
                            bar.name.c_str(),
                            bar.value,
                            bar.unit.c_str(),
                            bar.value < bar.low ? "at least" : "at most",
                            bar.value < bar.low ? bar.low : bar.high));
  }
  return missed;
}

}  // namespace vantage
