#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/result.h"
#include "fusion/confusion/confusion_model.h"
#include "perception/model/object_model.h"
#include "tools/evaluate/confusion_strategies.h"
#include "tools/evaluate/simulated_sequence.h"

namespace vantage {

/// How many views strategies need: every sequence is one pose of an object and one first view;
/// from there each strategy goes its own way. The noise of a step is the same for all of them.
struct ConfusionViewsParameters {
  SimulationParameters simulation;     ///< in `views` the sequences' distances are not used
  int sequences = 40;                  ///< of each object
  int views = 15;                      ///< of each sequence
  int candidates = 500;                ///< views to choose from, evenly over the band
  double lowest_elevation_deg = 15.0;  ///< deg, of the candidates
  double highest_elevation_deg = 80.0;
  double distance = 0.75;       ///< m, to the object's center
  double right_angle = 15.0;    ///< deg, from the truth modulo symmetry, of the right mode
  int threads = 1;              ///< more or fewer change nothing but the time
  std::filesystem::path cache;  ///< folder of simulated views

  Result<void> Validate() const;
};

/// One view of a sequence and what is believed after it.
struct ConfusionStep {
  int candidate = 0;
  bool found = false;
  double detection_deg = 0.0;  ///< error of the detection modulo symmetry; NaN when not found
  double final_deg = 0.0;      ///< error of the fused orientation alike; NaN while there is none
  double right_mass = 0.0;     ///< of the belief, on orientations in the right mode
  double best_mass = 0.0;      ///< of its best hypothesis
  bool is_best_right = false;
};

/// [sequence][step] of one object and strategy.
using StrategyRuns = std::vector<std::vector<ConfusionStep>>;

struct ConfusionViews {
  /// [object][strategy]; as many objects as are done.
  std::vector<std::vector<StrategyRuns>> runs;
  bool is_complete = false;  ///< false after a stop
  int64_t views_made = 0;
  int64_t views_reused = 0;
  std::vector<std::string> notes;  ///< on damage in the cache
};

/// An object and what is known of its confusions.
struct ConfusedObject {
  const ObjectModel* model = nullptr;
  const ConfusionModel* confusion = nullptr;
};

/// Camera poses evenly over a band of the sphere about a point, looking at it (the golden spiral of
/// Gonzalez, "Measurement of areas on a sphere using Fibonacci and latitude-longitude lattices",
/// Mathematical Geosciences 2010); the world's z is up in the image.
std::vector<Pose> BandOfViews(const Eigen::Vector3d& target,
                              double distance,
                              const ConfusionViewsParameters& parameters);

/// Runs every strategy on every sequence. Simulated views are cached by all that they depend on,
/// so that another table or strategy costs only views that nobody took yet. The same result for any
/// number of threads.
/// @param progress is called by one thread at a time with sequences done and all.
/// Errors: parameters, the cache, a model that can't be trained.
Result<ConfusionViews> RunConfusionViews(std::span<const ConfusedObject> objects,
                                         std::span<const ConfusionStrategy> strategies,
                                         const ConfusionViewsParameters& parameters,
                                         const std::stop_token& stop,
                                         const std::function<void(int64_t, int64_t)>& progress);

}  // namespace vantage
