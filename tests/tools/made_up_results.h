#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/rng.h"
#include "tools/evaluate/evaluation_results.h"
#include "tools/evaluate/paper_figures.h"

namespace vantage {

/// Results of the size and spread of real ones, made up.
class MadeUpResults {
 public:
  explicit MadeUpResults(uint64_t seed) : rng_(seed) {
    results_.command = "vantage-evaluate --seed 7 --out out/evaluate/paper";
    results_.version = "1.0";
    results_.seed = 18'446'744'073'709'551'557U;
    results_.wrong_mode_deg = 15.0;
    results_.views_per_sequence = kViews;
    results_.histogram_k = 32;
    results_.best_ours = "density_mode";
    AddMethods();
    AddGrid();
    AddSweep();
    for (int i = 0; i < kObjects; ++i) {
      AddCircle(i);
      AddSequences(i);
    }
    AddAccuracy();
  }
  [[nodiscard]] const EvaluationResults& results() const { return results_; }

  static constexpr int kObjects = 18;
  static constexpr int kMethods = 14;
  static constexpr int kSequences = 60;
  static constexpr int kViews = 12;
  static constexpr int kCircleViews = 30;

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  // Errors spread over a decade round a median.
  double Error(double median) { return median * std::exp(0.8 * rng_.Normal()); }
  double Level(size_t method) const {
    static constexpr double kLevels[kMethods] = {
        48, 0.32, 2.9, 2.7, 0.11, 0.095, 0.085, 0.04, 0.05, 0.06, 0.2, 0.5, 0.9, 0.7};
    return kLevels[method];
  }
  double SymmetricPart(double error, int object) {
    return object % 5 == 2 && rng_.Uniform() < 0.4 ? 180.0 - error : error;
  }

  void AddMethods() {
    results_.methods = {{kMeanId, "Mean", "all detections", false, false},
                        {kKnnId, "KNN clustering", "k = 5", false, false},
                        {kVotingId, "Voting", "", true, false},
                        {kVwVotingId, "VW voting", "", true, false},
                        {kCwId, "CW clustering", "sigma 4 deg", true, false},
                        {kCwVwId, "CW+VW clustering", "w_min 0.7, w_max 0.9", true, false},
                        {"cw_vw_64", "CW+VW clustering, k = 64", "", true, true},
                        {"density_mode", "Density mode", "exact kernel density", true, true},
                        {"joint", "Joint refinement", "", true, true},
                        {"robust_mean", "Robust mean, Weiszfeld's algorithm", "L1", false, true},
                        {kParticleFilterId, "Particle filter", "68,416 particles", false, false},
                        {kBinghamProductId, "BMM M+R", "", false, false},
                        {kBinghamParticlesId, "BMM SMC", "", false, false},
                        {"mean_shift", "Mean shift on SO(3)", "", false, true}};
  }

  void AddGrid() {
    results_.grids = {{8, 8480, 10.27, 1.38, 0.4, 0.002},
                      {16, 68416, 5.12, 0.64, 3.1, 0.01},
                      {32, 548496, 2.57, 0.32, 24.8, 0.09},
                      {64, 4389888, 1.28, 0.16, 198.0, 0.7}};
    results_.grid_angles.bin_width_deg = 2.0;
    for (int i = 0; i < 90; ++i) {
      const double theta = (2.0 * i + 1.0) * 3.14159265358979 / 180.0;
      const double even = 12189.0 * std::pow(std::sin(theta / 2), 2);
      results_.grid_angles.counts.push_back(
          std::max<int64_t>(0, static_cast<int64_t>(even * (1 + 0.08 * rng_.Normal()))));
    }
    results_.grid_distances.bin_width_deg = 0.1;
    for (int i = 0; i < 60; ++i) {
      const double z = (0.1 * i + 0.05 - 2.57) / 0.32;
      results_.grid_distances.counts.push_back(static_cast<int64_t>(68000 * std::exp(-z * z / 2)));
    }
  }

  void AddSweep() {
    for (int i = 1; i <= 9; ++i) {
      results_.sweep.w_min.push_back(0.1 * i);
      results_.sweep.w_max.push_back(0.1 * i);
    }
    for (const double w_min : results_.sweep.w_min) {
      std::vector<double> errors;
      std::vector<double> rates;
      for (const double w_max : results_.sweep.w_max) {
        const double error = 12 * std::exp(-6.5 * (w_min - 0.1) - 1.2 * (w_max - 0.2));
        errors.push_back(w_min > w_max ? kNone : Error(error));
        rates.push_back(w_min > w_max ? kNone : 0.03 + 0.2 * std::exp(-6 * w_min));
      }
      results_.sweep.mean_error_deg.push_back(errors);
      results_.sweep.wrong_mode_rate.push_back(rates);
    }
  }

  static std::string Name(int object) {
    static constexpr const char* kNames[kObjects] = {"bottle",
                                                     "bracket",
                                                     "carton",
                                                     "duck",
                                                     "filter",
                                                     "gear",
                                                     "hub",
                                                     "mug",
                                                     "shampoo",
                                                     "pony",
                                                     "trefoil",
                                                     "pitcher",
                                                     "control",
                                                     "rhino",
                                                     "pressure",
                                                     "spray",
                                                     "fish",
                                                     "dwarf"};
    return kNames[object];
  }

  void AddCircle(int object) {
    CircleErrors errors;
    errors.model_id = Name(object);
    errors.symmetry = object % 5 == 2 ? "half turn about z" : "none";
    for (int view = 0; view < kCircleViews; ++view) {
      double error = rng_.Uniform() < 0.2 ? 180 * rng_.Uniform() : Error(1.6);
      if (rng_.Uniform() < 0.08) error = kNone;
      errors.detection_symmetric_deg.push_back(std::min(error, 180.0));
      errors.detection_deg.push_back(SymmetricPart(errors.detection_symmetric_deg.back(), object));
    }
    for (size_t method = 0; method < kMethods; ++method) {
      errors.step_symmetric_deg.push_back(Steps(Level(method), object));
      errors.step_deg.emplace_back();
      for (const double error : errors.step_symmetric_deg.back()) {
        errors.step_deg.back().push_back(SymmetricPart(error, object));
      }
    }
    if (object % 6 == 4) {
      for (int run = 0; run < 20; ++run) errors.particle_runs_deg.push_back(Steps(0.2, object));
    }
    results_.circle.push_back(errors);
  }

  std::vector<double> Steps(double level, int object) {
    std::vector<double> steps;
    const double floor = Error(level);
    for (int view = 0; view < kCircleViews; ++view) {
      const double error = floor * (1 + 12 * std::exp(-view / 4.0)) * (1 + 0.1 * rng_.Uniform());
      steps.push_back(view < object % 3 ? kNone : std::min(error, 180.0));
    }
    return steps;
  }

  void AddSequences(int object) {
    SequenceErrors errors;
    errors.model_id = Name(object);
    errors.num_views = kSequences * kViews;
    errors.num_found = errors.num_views * 9 / 10;
    for (int i = 0; i < errors.num_found; ++i) errors.detection_deg.push_back(Error(1.6));
    for (size_t method = 0; method < kMethods; ++method) {
      std::vector<double> finals;
      for (int i = 0; i < kSequences; ++i) {
        double error = rng_.Uniform() < 0.05 ? 180 * rng_.Uniform() : Error(1.4 * Level(method));
        if (rng_.Uniform() < 0.01) error = kNone;
        finals.push_back(std::min(error, 180.0));
      }
      errors.final_deg.push_back(finals);
      errors.step_median_deg.emplace_back(kViews, Level(method));
    }
    results_.sequences.push_back(errors);
  }

  void AddAccuracy() {
    for (size_t method = 0; method < kMethods; ++method) {
      const double level = 1.4 * Level(method);
      const double rate = 0.04 + 0.004 * level;
      const double difference = level - 1.4 * Level(7);
      MethodAccuracy accuracy;
      accuracy.median_deg = {level, 0.93 * level, 1.08 * level};
      accuracy.mean_deg = {level + 2, level + 1.6, level + 2.5};
      accuracy.wrong_mode_rate = {rate, rate - 0.012, rate + 0.013};
      accuracy.median_difference_deg = {difference, difference - 0.02, difference + 0.03};
      accuracy.difference_of_medians_deg = {difference, difference - 0.03, difference + 0.04};
      accuracy.difference_of_wrong_mode_rates = {rate - 0.0402, rate - 0.047, rate - 0.034};
      accuracy.seconds_per_view = 2e-5 * std::pow(2.6, static_cast<double>(method));
      accuracy.num_without_estimate = 9;
      results_.accuracy.push_back(accuracy);
    }
  }

  Rng rng_;
  EvaluationResults results_;
};

}  // namespace vantage
