// pose_comparison: estimates the pose of one object alone in simulated views with our estimators
// and their peers, in turn on each view, on one core. Writes one JSON object a line, of one
// estimate each; vantage-bench-table makes the tables of them.
// Ours estimate a view thrice, of which the median time counts; the peers, which take long enough
// for a cold cache not to matter, once.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/format.h"
#include "nodes/command_line.h"
#include "tests/bench/object_views.h"
#include "tests/bench/pose_comparison/compared_estimator.h"
#include "tests/bench/pose_comparison/compared_models.h"
#include "tools/evaluate/pose_success.h"

namespace vantage {
namespace {

using nlohmann::json;

constexpr double kLeastVisibleShare = 0.05;  // Of the surface; views that show less don't count.

struct Options {
  int views = 100;
  int peer_views = 20;
  uint64_t seed = 1;
  std::vector<std::string> models;
  size_t first = 0;
  size_t step = 1;
  std::vector<std::string> estimators;
  std::string meshes = VANTAGE_SOURCE_DIR "/../shared/data/meshes";
  std::string output;
};

struct Estimate {
  std::optional<Pose> T_camera_object;
  StageClock stages;
};

// That which took the median time.
Estimate EstimateTimed(const EstimatorKind& kind,
                       ComparedEstimator& estimator,
                       const SegmentedView& view) {
  constexpr size_t kRepeats = 3;
  std::vector<Estimate> estimates(kind.is_peer ? 1 : kRepeats);
  for (Estimate& each : estimates) {
    each.T_camera_object = estimator.Estimate(view, &each.stages);
    each.stages.End();
  }
  const auto middle = estimates.begin() + static_cast<std::ptrdiff_t>(estimates.size() / 2);
  std::nth_element(
      estimates.begin(), middle, estimates.end(), [](const Estimate& a, const Estimate& b) {
        return a.stages.total_ms() < b.stages.total_ms();
      });
  return *middle;
}

json Record(const ObjectModel& model, const Estimate& estimate, const ObjectView& view) {
  json record = {{"model", model.id},
                 {"ms", estimate.stages.total_ms()},
                 {"stages_ms", estimate.stages.ms()},
                 {"found", estimate.T_camera_object.has_value()},
                 {"within", false},
                 {"success", false}};
  if (!estimate.T_camera_object) return record;
  const PoseSuccess success =
      JudgePose(model, view.T_camera_object, *estimate.T_camera_object, view.depth, view.camera);
  record["angle_deg"] = success.angle / kDegree;
  record["distance_mm"] = 1e3 * success.distance;
  record["within"] = success.is_within;
  record["success"] = success.succeeded();
  return record;
}

SegmentedView Segmented(const ObjectView& view) {
  SegmentedView segmented{view.camera, view.depth, {}};
  for (int v = 0; v < view.depth.height; ++v) {
    for (int u = 0; u < view.depth.width; ++u) {
      const float depth = view.depth.at(u, v);
      if (!std::isfinite(depth)) continue;
      segmented.points.push_back(
          view.camera.Unproject(u, v, static_cast<double>(depth)).cast<float>());
    }
  }
  return segmented;
}

void Compare(const ObjectModel& model,
             std::span<const EstimatorKind> kinds,
             const Options& options,
             std::ostream& out) {
  std::vector<std::unique_ptr<ComparedEstimator>> estimators;
  std::string training;
  for (const EstimatorKind& kind : kinds) {
    StageClock clock;
    clock.Begin("training");
    estimators.push_back(kind.make(model));
    clock.End();
    training += Format(" %s %.0f", kind.name.c_str(), clock.total_ms());
  }
  const std::vector<ObjectView> views = MakeObjectViews(model, options.views, options.seed);
  int used = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    if (views[i].visible_share < kLeastVisibleShare) continue;
    ++used;
    const SegmentedView segmented = Segmented(views[i]);
    for (size_t k = 0; k < kinds.size(); ++k) {
      if (kinds[k].is_peer && used > options.peer_views) continue;
      const Estimate estimate = EstimateTimed(kinds[k], *estimators[k], segmented);
      json record = Record(model, estimate, views[i]);
      record["estimator"] = kinds[k].name;
      record["is_peer"] = kinds[k].is_peer;
      record["view"] = i;
      out << record.dump() << '\n';
    }
  }
  std::printf("%-22s %d views, %d more show too little of it; training ms:%s\n",
              model.id.c_str(),
              used,
              options.views - used,
              training.c_str());
  std::fflush(stdout);
}

Result<std::vector<EstimatorKind>> SelectEstimators(const std::vector<std::string>& names) {
  std::vector<EstimatorKind> selected;
  std::string known;
  for (const EstimatorKind& kind : EstimatorKinds()) {
    known += (known.empty() ? "" : ", ") + kind.name;
    if (names.empty() || std::find(names.begin(), names.end(), kind.name) != names.end()) {
      selected.push_back(kind);
    }
  }
  if (!names.empty() && selected.size() != names.size()) {
    return Error{ErrorCode::kInvalidArgument, "--estimators expects some of: " + known};
  }
  return selected;
}

Result<void> Run(const Options& options) {
  const Result<std::vector<EstimatorKind>> kinds = SelectEstimators(options.estimators);
  if (!kinds) return kinds.error();
  std::ofstream out(options.output);
  for (size_t i = options.first; i < options.models.size(); i += options.step) {
    const std::string& name = options.models[i];
    const Result<ObjectModel> model = MakeComparedModel(name, options.meshes);
    if (!model && model.error().code == ErrorCode::kNotFound) {
      std::printf("%-22s left out: %s\n", name.c_str(), model.error().message.c_str());
      continue;
    }
    if (!model) return model.error();
    Compare(*model, *kinds, options, out);
    out.flush();
  }
  if (!out) return Error{ErrorCode::kIo, options.output + " can't be written"};
  return {};
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Options options;
  options.models = vantage::ComparedModelNames();
  CLI::App app("Our pose estimators and others' on the same views", "pose_comparison");
  app.add_option("--views", options.views, "of each model")->check(CLI::Range(1, 100000));
  app.add_option("--peer-views", options.peer_views, "of each model, the first ones, for the peers")
      ->check(CLI::Range(0, 100000));
  app.add_option("--seed", options.seed, "of the views")->check(CLI::Range(0, 1000000000));
  app.add_option("--models", options.models, "separated by commas")->delimiter(',');
  app.add_option(
      "--first", options.first, "number of the first of the models that is used, from 0");
  app.add_option("--step", options.step, "to the next one that is used, so that others share them")
      ->check(CLI::Range(1, 1000));
  app.add_option("--estimators", options.estimators, "separated by commas")->delimiter(',');
  app.add_option("--meshes", options.meshes, "folder of scans; those that it lacks are left out");
  app.add_option("--output", options.output, "JSON lines to write")->required();
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  const vantage::Result<void> result = vantage::Run(options);
  if (result) return 0;
  std::fprintf(stderr, "pose_comparison: %s\n", result.error().message.c_str());
  return 2;
}
