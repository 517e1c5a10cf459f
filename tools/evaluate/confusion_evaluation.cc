#include "tools/evaluate/confusion_evaluation.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include "common/format.h"
#include "perception/model/model_generator.h"
#include "perception/model/symmetry_text.h"
#include "tools/contingency/trial_setup.h"
#include "tools/evaluate/confusion_fusion.h"
#include "tools/evaluate/confusion_pictures.h"
#include "tools/evaluate/confusion_statistics.h"
#include "tools/evaluate/confusion_strategies.h"
#include "tools/evaluate/confusion_tables.h"
#include "tools/evaluate/confusion_views.h"
#include "tools/evaluate/detection_run.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// Objects that look alike from several sides: some of the bundled ones, and all that are generated
// to be so.
std::vector<std::string> AmbiguousObjects() {
  std::vector<std::string> names = {"filter", "hub", "sauce", "spray", "mug", "pitcher"};
  for (const std::string& name : GeneratedObjectNames(ObjectSet::kAmbiguous)) names.push_back(name);
  return names;
}
const std::vector<std::string> kReweighted = {"filter", "shampoo", "turtle"};  // Table 3.
const std::vector<std::string> kWithPeaks = {"valve",
                                             "brick"};          // Fig. 16, 17: three and two sides.
const std::vector<std::string> kStepped = {"valve", "turtle"};  // Fig. 18.
constexpr const char* kDrawn = "cross";                         // Fig. 5, 6.
constexpr int kCircleViews = 30;
constexpr int kPaperK = 8;
constexpr int kFineK = 32;

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Everything about one object.
struct Subject {
  ObjectModel model;
  FoundTable found;
  std::unique_ptr<ConfusionModel> confusion;
  std::vector<DetectionSequence> circles;
};

Result<ObjectModel> FindModel(const fs::path& models, const std::string& name) {
  std::error_code ignored;
  const fs::path folder = models / name;
  return FindTrialModel(fs::is_directory(folder, ignored) ? folder.string() : name);
}

Result<std::vector<Subject>> FindSubjects(const ConfusionRequest& request) {
  std::vector<std::string> names = request.use;
  if (names.empty()) {
    names = AmbiguousObjects();
    for (const auto* list : {&kReweighted, &kWithPeaks, &kStepped}) {
      names.insert(names.end(), list->begin(), list->end());
    }
  }
  std::vector<Subject> subjects;
  for (const std::string& name : names) {
    const bool is_there = std::any_of(
        subjects.begin(), subjects.end(), [&](const Subject& one) { return one.model.id == name; });
    if (is_there) continue;
    Result<ObjectModel> model = FindModel(request.models, name);
    if (!model) return model.error();
    subjects.push_back({std::move(model).value(), {}, nullptr, {}});
  }
  return subjects;
}

Result<bool> FindTables(const ConfusionRequest& request,
                        const std::stop_token& stop,
                        const ConfusionProgress& progress,
                        std::vector<Subject>* subjects,
                        ConfusionResults* results) {
  ConfusionTableParameters parameters;
  parameters.seed = request.seed;
  parameters.k = kPaperK;
  parameters.threads = request.threads;
  parameters.models = request.models;
  parameters.cache = request.cache / "confusion";
  for (Subject& subject : *subjects) {
    auto found = FindOrMeasureTable(
        subject.model, parameters, stop, progress("directions of " + subject.model.id));
    if (!found) return found.error();
    if (!*found) return false;
    subject.found = std::move(**found);
    Result<ConfusionModel> confusion =
        ConfusionModel::Make(subject.found.table, subject.model.symmetry);
    if (!confusion) return confusion.error();
    subject.confusion = std::make_unique<ConfusionModel>(std::move(confusion).value());
    results->tables.push_back(FactsOf(subject.model, subject.found, *subject.confusion));
  }
  return true;
}

Result<bool> FindCircles(const ConfusionRequest& request,
                         const std::stop_token& stop,
                         const ConfusionProgress& progress,
                         std::vector<Subject>* subjects) {
  std::vector<ObjectModel> models;
  std::vector<Subject*> seen;
  for (Subject& subject : *subjects) {
    if (!Contains(kReweighted, subject.model.id) && !Contains(kWithPeaks, subject.model.id)) {
      continue;
    }
    models.push_back(subject.model);
    seen.push_back(&subject);
  }
  DetectionRequest detections;
  detections.simulation.seed = request.seed;
  detections.simulation.views.circle_views = kCircleViews;
  detections.circles = std::max(1, request.sequences / 4);
  detections.random_sequences = 0;
  detections.threads = request.threads;
  detections.cache = request.cache;
  const auto bar = progress("views on circles");
  Result<DetectionRun> run =
      RunDetections(models, detections, stop, [&bar](const DetectionProgress& done) {
        bar(done.views_done, done.views_total);
      });
  if (!run) return run.error();
  if (!run->is_complete) return false;
  for (size_t i = 0; i < seen.size(); ++i) {
    seen[i]->circles = std::move(run->models[i].circles);
  }
  return true;
}

Result<void> Reweight(const std::vector<Subject>& subjects, ConfusionResults* results) {
  std::vector<ReweightedObject> reweighted;
  for (const Subject& subject : subjects) {
    const ReweightedObject object{&subject.model, &subject.found.table, subject.circles};
    if (Contains(kReweighted, subject.model.id)) reweighted.push_back(object);
    if (!Contains(kWithPeaks, subject.model.id)) continue;
    const Result<void> appended =
        AppendPeaks(kPaperK, object, {1, 12, kCircleViews}, "fig16", results);
    if (!appended) return appended;
  }
  if (reweighted.empty()) return {};
  for (const int k : {kPaperK, kFineK}) {
    Result<ReweightingTable> table = CompareReweighting(k, reweighted);
    if (!table) return table.error();
    results->reweighting.push_back(std::move(table).value());
  }
  return {};
}

void DrawTables(const std::vector<Subject>& subjects, ConfusionResults* results) {
  constexpr double kAroundIdentity = 20.0 * kDegree;
  for (const Subject& subject : subjects) {
    if (subject.model.id != kDrawn) continue;
    const ContingencyTable& table = subject.found.table;
    const So3Grid grid(kPaperK);
    results->pictures.push_back({"fig5-shares",
                                 "fig5",
                                 std::string(kDrawn) + ": by the square root of the share",
                                 DrawConfusionMatrix(table, grid, {.is_marking_any = false})});
    results->pictures.push_back({"fig5-any",
                                 "fig5",
                                 std::string(kDrawn) + ": every entry other than 0 at the maximum",
                                 DrawConfusionMatrix(table, grid, {.is_marking_any = true})});
    results->pictures.push_back({"fig6-all",
                                 "fig6",
                                 std::string(kDrawn) + ": all weights",
                                 DrawSymmetryWeights(table, 0.0)});
    results->pictures.push_back({"fig6-others",
                                 "fig6",
                                 std::string(kDrawn) + ": without those up to 20 degrees",
                                 DrawSymmetryWeights(table, kAroundIdentity)});
  }
}

Result<bool> FollowStrategies(const ConfusionRequest& request,
                              const std::stop_token& stop,
                              const ConfusionProgress& progress,
                              const std::vector<Subject>& subjects,
                              ConfusionResults* results) {
  ConfusionViewsParameters parameters;
  parameters.simulation.seed = request.seed;
  parameters.sequences = request.sequences;
  parameters.views = request.views;
  parameters.threads = request.threads;
  parameters.cache = request.cache / "views";
  const std::vector<ConfusionStrategy> strategies = ConfusionStrategies(request.views);
  const std::vector<std::string> counted_ids =
      request.use.empty() ? AmbiguousObjects() : request.use;
  std::vector<ConfusedObject> objects;
  std::vector<const Subject*> seen;
  for (const Subject& subject : subjects) {
    const bool is_counted = Contains(counted_ids, subject.model.id);
    if (!is_counted && !Contains(kStepped, subject.model.id)) continue;
    objects.push_back({&subject.model, subject.confusion.get()});
    seen.push_back(&subject);
  }
  const Result<ConfusionViews> views =
      RunConfusionViews(objects, strategies, parameters, stop, progress("sequences"));
  if (!views) return views.error();
  for (const std::string& note : views->notes) std::fprintf(stderr, "%s\n", note.c_str());
  if (!views->is_complete) return false;
  results->candidates = parameters.candidates;
  results->right_angle_deg = parameters.right_angle;
  for (const ConfusionStrategy& strategy : strategies) {
    results->strategies.push_back(strategy.label);
    results->strategy_ids.push_back(strategy.id);
  }
  std::vector<std::vector<StrategyRuns>> counted;
  std::vector<ObjectViewsNeeded> named;
  for (size_t i = 0; i < seen.size(); ++i) {
    const ObjectModel& model = seen[i]->model;
    if (Contains(kStepped, model.id)) AppendStepQuartiles(views->runs[i], model.id, results);
    if (!Contains(counted_ids, model.id)) continue;
    counted.push_back(views->runs[i]);
    named.push_back({model.id, SymmetryText(model.symmetry), {}, {}});
  }
  SummarizeConfusionViews(counted, named, results);
  return true;
}

}  // namespace

Result<bool> EvaluateConfusion(const ConfusionRequest& request,
                               const std::stop_token& stop,
                               const ConfusionProgress& progress,
                               ConfusionResults* results) {
  results->seed = request.seed;
  results->sequences = request.sequences;
  results->views = request.views;
  Result<std::vector<Subject>> subjects = FindSubjects(request);
  if (!subjects) return subjects.error();
  const Result<bool> measured = FindTables(request, stop, progress, &*subjects, results);
  if (!measured || !*measured) return measured;
  const Result<bool> seen = FindCircles(request, stop, progress, &*subjects);
  if (!seen || !*seen) return seen;
  if (const Result<void> reweighted = Reweight(*subjects, results); !reweighted) {
    return reweighted.error();
  }
  DrawTables(*subjects, results);
  return FollowStrategies(request, stop, progress, *subjects, results);
}

}  // namespace vantage
