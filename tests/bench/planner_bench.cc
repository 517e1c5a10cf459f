// Choosing the next of 500 views: three objects that look alike from most sides, 30 hypotheses
// each.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "planner/confusion_heuristic.h"
#include "planner/information_gain.h"
#include "planner/next_best_view.h"
#include "planner/occlusion.h"
#include "planner/view_candidates.h"
#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

constexpr int kOrder = 10;
constexpr int kNumHypotheses = 30;

const ConfusionModel& Model() {
  static const ConfusionModel model = MakeConfusion(RandomTurns(kOrder, 391, 1));
  return model;
}

std::vector<Pose> Candidates(int count) {
  ViewCandidateParameters parameters;
  parameters.count = count;
  return MakeViewCandidates(parameters);
}

// A body of revolution of 800 triangles.
TriangleMesh Body() {
  constexpr uint32_t kRings = 21;
  constexpr uint32_t kSteps = 20;
  TriangleMesh mesh;
  for (uint32_t ring = 0; ring < kRings; ++ring) {
    const float z = 0.14F * static_cast<float>(ring) / (kRings - 1) - 0.07F;
    const float radius = 0.04F + 0.01F * std::sin(60.0F * z);
    for (uint32_t step = 0; step < kSteps; ++step) {
      const float angle = 6.2831853F * static_cast<float>(step) / kSteps;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
      if (ring + 1 == kRings) continue;
      const uint32_t here = ring * kSteps + step;
      const uint32_t next = ring * kSteps + (step + 1) % kSteps;
      mesh.triangles.push_back({here, next, here + kSteps});
      mesh.triangles.push_back({next, next + kSteps, here + kSteps});
    }
  }
  return mesh;
}

struct Scene {
  Scene() {
    Rng rng(5);
    for (size_t i = 0; i < 3; ++i) {
      SyntheticObject turns;
      turns.order = kNumHypotheses;
      beliefs.push_back(RandomBelief(turns, rng.Rotation(), rng));
    }
    const double angle = 2.0 * std::numbers::pi / 3.0;
    for (size_t i = 0; i < 3; ++i) {
      PlannedObject object;
      object.instance_id = static_cast<int>(i);
      object.model_id = "body";
      object.center_world =
          Eigen::AngleAxisd(angle * static_cast<double>(i), Eigen::Vector3d::UnitZ()) *
          Eigen::Vector3d(0.08, 0.0, 0.07);
      object.T_world_object.translation() = object.center_world;
      object.confirmed = true;
      object.confusion = &Model();
      object.belief = beliefs[i];
      object.mesh = &mesh;
      object.radius = 0.09;
      objects.push_back(object);
    }
  }
  [[nodiscard]] PlanningState State() const {
    return {candidates, visited, objects, Eigen::Vector3d::Zero()};
  }

  TriangleMesh mesh = Body();
  std::vector<std::vector<OrientationHypothesis>> beliefs;
  std::vector<PlannedObject> objects;
  std::vector<Pose> candidates = Candidates(500);
  std::vector<Pose> visited = Candidates(5);
};

// After 20 views, which were the best there were.
void HeuristicLookup(benchmark::State& state) {
  const ConfusionHeuristic heuristic(Model());
  std::vector<bool> visited(heuristic.Order().size(), false);
  for (size_t i = 0; i < 20; ++i) visited[static_cast<size_t>(heuristic.Order()[i])] = true;
  for (auto _ : state) {
    benchmark::DoNotOptimize(visited);
    benchmark::DoNotOptimize(heuristic.Next(visited));
  }
}

void HeuristicOrder(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(ConfusionHeuristic(Model()));
}

void HeuristicGains(benchmark::State& state) {
  const Scene scene;
  const ViewCriterion criterion = ConfusionHeuristicView({{"body", &Model()}});
  for (auto _ : state) benchmark::DoNotOptimize(criterion.gains(scene.State()));
}

// Entropy of the belief less the mean of the posteriors' entropies, outcome by outcome.
double EnumeratedInformation(const std::vector<OrientationHypothesis>& belief, const Pose& view) {
  const ConfusionModel& model = Model();
  const auto entropy = [](double p) { return p > 0.0 ? -p * std::log(p) : 0.0; };
  std::map<int, std::vector<double>> joint;
  for (size_t h = 0; h < belief.size(); ++h) {
    const int direction =
        model.DirectionOf(Eigen::Quaterniond(view.linear().transpose()) * belief[h].q_world_object);
    const auto add = [&](int outcome, double share) {
      joint.try_emplace(outcome, belief.size(), 0.0);
      joint[outcome][h] += belief[h].probability * model.WithOutliers(share);
    };
    for (int mode = 0; mode < model.num_modes(); ++mode) {
      const Eigen::Quaterniond q = belief[h].q_world_object * model.Difference(mode);
      int outcome = 0;
      while (GeodesicAngle(q, belief[static_cast<size_t>(outcome)].q_world_object) > 0.02)
        ++outcome;
      add(outcome, model.ShareFrom(direction, mode));
    }
    add(-1, model.Scattered(direction));
    add(-2, model.Missed(direction) - model.Scattered(direction));
  }
  double information = BeliefEntropy(belief);
  for (const auto& [outcome, row] : joint) {
    double sum = 0.0;
    for (const double p : row) sum += p;
    for (const double p : row) information -= sum * entropy(p / sum);
  }
  return information;
}

void InformationGainOfViews(benchmark::State& state) {
  Scene scene;
  scene.candidates = Candidates(static_cast<int>(state.range(0)));
  const ViewCriterion criterion = InformationGainView();
  for (auto _ : state) benchmark::DoNotOptimize(criterion.gains(scene.State()));
  double largest = 0.0;
  InformationGain gain(Model(), scene.beliefs[0]);
  for (size_t i = 0; i < scene.candidates.size(); i += 25) {
    const double expected = EnumeratedInformation(scene.beliefs[0], scene.candidates[i]);
    const double found = gain.From(-scene.candidates[i].linear().col(2), 1.0).information;
    largest = std::max(largest, std::abs(found - expected));
  }
  state.counters["nat_from_enumerated"] = largest;
}

void OcclusionOf500Views(benchmark::State& state) {
  const Scene scene;
  size_t hidden = 0;
  for (auto _ : state) {
    const std::vector<Visibility> found = FindOcclusion({}, scene.candidates, scene.objects);
    hidden = static_cast<size_t>(
        std::ranges::count_if(found, [](const Visibility& one) { return one.share < 1.0; }));
  }
  state.counters["partly_hidden"] = static_cast<double>(hidden);
}

// All that a decision takes, the objects having moved.
void DecisionOf500Views(benchmark::State& state) {
  const Scene scene;
  const ViewCriterion criterion = InformationGainView();
  const std::vector<CandidateStatus> status(scene.candidates.size());
  for (auto _ : state) {
    const std::vector<Visibility> visibility = FindOcclusion({}, scene.candidates, scene.objects);
    PlanningState planning = scene.State();
    planning.visibility = visibility;
    benchmark::DoNotOptimize(
        SelectNextView(planning, criterion, {.status = status, .travel_weight = 0.02}));
  }
}

}  // namespace

BENCHMARK(HeuristicLookup)->Unit(benchmark::kMicrosecond);
BENCHMARK(HeuristicOrder)->Unit(benchmark::kMillisecond);
BENCHMARK(HeuristicGains)->Unit(benchmark::kMillisecond);
BENCHMARK(InformationGainOfViews)->Name("InformationGain")->Arg(500)->Unit(benchmark::kMillisecond);
BENCHMARK(OcclusionOf500Views)->Name("OcclusionOf500Views/3")->Unit(benchmark::kMillisecond);
BENCHMARK(DecisionOf500Views)->Unit(benchmark::kMillisecond);

}  // namespace vantage

BENCHMARK_MAIN();
