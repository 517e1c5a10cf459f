// Regenerates the paper's evaluation: simulated views, the real estimator, every fusion method on
// the same detections, a report. Or what measured confusion is good for. Or tunes the methods on
// other sequences. Or holds single views of real datasets against their ground truth. Or what the
// hand-eye calibration and the refinement over several views reach.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/format.h"
#include "common/result.h"
#include "fusion/so3_grid.h"
#include "nodes/command_line.h"
#include "nodes/models_config.h"
#include "perception/model/file_bytes.h"
#include "perception/model/object_model.h"
#include "tools/evaluate/accuracy_text.h"
#include "tools/evaluate/clustering_sweep.h"
#include "tools/evaluate/confusion_evaluation.h"
#include "tools/evaluate/confusion_report.h"
#include "tools/evaluate/confusion_statistics.h"
#include "tools/evaluate/confusion_text.h"
#include "tools/evaluate/dataset_report.h"
#include "tools/evaluate/dataset_run.h"
#include "tools/evaluate/dataset_text.h"
#include "tools/evaluate/detection_run.h"
#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/fusion_methods.h"
#include "tools/evaluate/grid_statistics.h"
#include "tools/evaluate/handeye_evaluation.h"
#include "tools/evaluate/handeye_report.h"
#include "tools/evaluate/handeye_text.h"
#include "tools/evaluate/method_cache.h"
#include "tools/evaluate/refinement_report.h"
#include "tools/evaluate/refinement_study.h"
#include "tools/evaluate/report_writer.h"
#include "tools/evaluate/tuning.h"
#include "tools/support/gnuplot.h"
#include "tools/support/interrupt.h"
#include "tools/support/shown_progress.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int kEvaluationSequences = 60;
constexpr int kTuningSequences = 10;
constexpr int kConfusionSequences = 40;
constexpr int kRefinementSequences = 20;
constexpr int kHandEyeTrials = 1000;
constexpr int kEvaluationViews = 12;
constexpr int kConfusionViews = 15;
constexpr uint64_t kTuningSeed = 1000;  // Added to the evaluation's.

struct Arguments {
  bool paper = false;
  bool confusion = false;
  bool tune = false;
  bool handeye = false;
  bool refinement = false;
  std::string turntable;  // Folder of real views for --refinement; empty: none.
  std::string dataset;    // Folder; empty: not that work.
  std::string meshes;     // Empty: beside the dataset.
  std::string estimator = "all";
  std::vector<std::string> methods;
  std::string models = "models";
  std::vector<std::string> use;
  std::string output = "out/evaluate";
  std::string name;    // Empty: of the work.
  int sequences = -1;  // Below 0: what suits the work.
  int views = -1;      // Alike.
  uint64_t seed = 1;
  int threads = 0;
  int k = 32;
  int largest_grid = 64;
  bool check = false;
};

Result<std::vector<ObjectModel>> LoadModels(const Arguments& arguments) {
  const Result<std::vector<std::string>> names = FindModels({arguments.models, arguments.use});
  if (!names) return names.error();
  std::vector<ObjectModel> models;
  for (const std::string& name : *names) {
    Result<ObjectModel> model = LoadObjectModel(fs::path(arguments.models) / name);
    if (!model) return model.error();
    models.push_back(std::move(model).value());
  }
  return models;
}

/// Random sequences of each model in Fig. 8, which takes longer than all methods but the slow ones.
constexpr size_t kSweptSequences = 5;

/// Detections of all models and what is kept of methods. Not complete after a stop.
struct Input {
  std::vector<ObjectModel> models;
  DetectionRun run;
  std::unique_ptr<MethodCache> cache;
};

Result<Input> MakeInput(const Arguments& arguments, const std::stop_token& stop) {
  Input input;
  Result<std::vector<ObjectModel>> models = LoadModels(arguments);
  if (!models) return models.error();
  input.models = std::move(models).value();
  const fs::path folder = fs::path(arguments.output) / "cache";
  const Result<uint64_t> program = HashOfThisProgram();
  if (!program) return program.error();
  auto cache = MethodCache::Create(folder / "methods", *program);
  if (!cache) return cache.error();
  input.cache = std::move(cache).value();

  DetectionRequest request;
  request.simulation.seed = arguments.seed + (arguments.tune ? kTuningSeed : 0);
  request.simulation.views.random_views = arguments.views;
  request.circles = arguments.tune ? 0 : 1;
  request.random_sequences = arguments.sequences;
  request.threads = arguments.threads;
  request.cache = folder;
  ShownProgress bar("views");
  Result<DetectionRun> run =
      RunDetections(input.models, request, stop, [&bar](const DetectionProgress& progress) {
        bar.Show(progress.views_done, progress.views_total);
      });
  if (!run) return run.error();
  input.run = std::move(run).value();
  for (const std::string& note : input.run.notes) std::fprintf(stderr, "%s\n", note.c_str());
  std::fprintf(stderr,
               "%lld views simulated, %lld from the cache\n",
               static_cast<long long>(input.run.views_made),
               static_cast<long long>(input.run.views_reused));
  return input;
}

void TellOfCache(MethodCache* cache) {
  for (const std::string& note : cache->Notes()) std::fprintf(stderr, "%s\n", note.c_str());
  std::fprintf(stderr,
               "%lld outcomes of slow methods from the cache\n",
               static_cast<long long>(cache->num_found()));
}

/// Of all models, one after the other: the circles where they are wanted, and random sequences, up
/// to a number of each model.
std::vector<EvaluatedSequence> Sequences(const Input& input,
                                         bool with_circles,
                                         size_t most_random = SIZE_MAX) {
  std::vector<EvaluatedSequence> all;
  for (size_t i = 0; i < input.models.size(); ++i) {
    const SymmetryGroup* symmetry = &input.models[i].symmetry;
    const ModelDetections& of_model = input.run.models[i];
    if (with_circles) {
      for (const auto& sequence : of_model.circles) all.push_back({&sequence, symmetry});
    }
    for (size_t j = 0; j < std::min(most_random, of_model.random.size()); ++j) {
      all.push_back({&of_model.random[j], symmetry});
    }
  }
  return all;
}

void MeasureGrids(int largest, EvaluationResults* results) {
  for (const int k : {8, 16, 32, 64, 128}) {
    if (k > largest) break;
    const GridMeasurement measured = MeasureGrid(k);
    results->grids.push_back(measured.statistics);
    if (k != 32) continue;
    results->grid_angles = measured.angles;
    results->grid_distances = measured.distances;
  }
}

std::string OptionsText(const Arguments& arguments) {
  std::string text = Format(" --models %s", arguments.models.c_str());
  for (const std::string& name : arguments.use) text += " --use " + name;
  return text + Format(" --sequences %d --views %d --seed %llu",
                       arguments.sequences,
                       arguments.views,
                       static_cast<unsigned long long>(arguments.seed));
}

std::string CommandText(const Arguments& arguments) {
  return "vantage-evaluate --paper" + OptionsText(arguments) + Format(" --k %d", arguments.k);
}

/// What is needed at the end is looked for at the start.
Result<void> PrepareOutput(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  const Result<std::string> figure = RunGnuplot("set terminal svg\nplot x\n");
  if (!figure) return figure.error();
  return {};
}

/// Those of all methods that were named; all where none was.
Result<std::vector<TunableMethod>> MethodsToTune(const So3Grid& grid,
                                                 const std::vector<std::string>& names) {
  std::vector<TunableMethod> all = TunableMethods(grid);
  if (names.empty()) return all;
  std::vector<TunableMethod> named;
  for (const std::string& name : names) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const TunableMethod& method) {
      return method.info.id == name;
    });
    if (found == all.end()) {
      std::string ids;
      for (const TunableMethod& method : all) ids += " " + method.info.id;
      return Error{ErrorCode::kNotFound,
                   Format("--method %s, expected one of%s", name.c_str(), ids.c_str())};
    }
    named.push_back(*found);
  }
  return named;
}

/// @return the exit code.
Result<int> Tune(const Arguments& arguments) {
  const Interrupt interrupt("the sequences in work");
  const Result<So3Grid> grid = So3Grid::Create(arguments.k);
  if (!grid) return grid.error();
  const Result<std::vector<TunableMethod>> methods = MethodsToTune(*grid, arguments.methods);
  if (!methods) return methods.error();
  const Result<Input> input = MakeInput(arguments, interrupt.token());
  if (!input) return input.error();
  if (!input->run.is_complete) return kInterrupted;
  const std::vector<EvaluatedSequence> sequences = Sequences(*input, false);
  if (sequences.empty()) {
    return Error{ErrorCode::kInvalidArgument, "--sequences = 0, expected at least 1 to tune on"};
  }
  TuningParameters parameters;
  parameters.run = {arguments.seed + kTuningSeed, arguments.threads, input->cache.get()};
  std::vector<TuningTrial> trials;
  for (const TunableMethod& method : *methods) {
    ShownProgress bar("sequences fused by " + method.info.id);
    const std::vector<TuningTrial> tried = TuneMethod(
        method, sequences, parameters, interrupt.token(), [&bar](int64_t done, int64_t total) {
          bar.Show(done, total);
        });
    if (tried.empty()) return kInterrupted;
    trials.insert(trials.end(), tried.begin(), tried.end());
  }
  TellOfCache(input->cache.get());
  const fs::path folder = fs::path(arguments.output) / "tuning";
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path file = folder / "tuning.csv";
  if (const auto written = WriteFileBytes(file, TuningCsv(trials)); !written) {
    return written.error();
  }
  std::printf("%zu sequences of seed %llu\n%s%s\n",
              sequences.size(),
              static_cast<unsigned long long>(parameters.run.seed),
              TuningText(trials).c_str(),
              file.c_str());
  return 0;
}

/// @return the exit code.
Result<int> Evaluate(const Arguments& arguments) {
  const Interrupt interrupt("the sequences in work");
  const Result<So3Grid> grid = So3Grid::Create(arguments.k);
  if (!grid) return grid.error();
  const fs::path folder =
      fs::path(arguments.output) / (arguments.name.empty() ? "paper" : arguments.name);
  if (const auto prepared = PrepareOutput(folder); !prepared) return prepared.error();
  const Result<Input> input = MakeInput(arguments, interrupt.token());
  if (!input) return input.error();
  if (!input->run.is_complete) return kInterrupted;

  EvaluationParameters parameters;
  parameters.seed = arguments.seed;
  parameters.threads = arguments.threads;
  parameters.figure10_models = {"filter", "hub", "bracket"};
  parameters.cache = input->cache.get();
  if (const auto valid = parameters.Validate(); !valid) return valid.error();
  EvaluationResults results;
  results.command = CommandText(arguments);
  results.version = VANTAGE_VERSION;
  results.views_per_sequence = arguments.views;
  results.histogram_k = arguments.k;
  {
    ShownProgress bar("sequences fused");
    const bool is_complete = EvaluateMethods(
        input->models,
        input->run.models,
        FusionMethods(*grid),
        parameters,
        interrupt.token(),
        [&bar](int64_t done, int64_t total) { bar.Show(done, total); },
        &results);
    if (!is_complete) return kInterrupted;
  }
  TellOfCache(input->cache.get());
  results.sweep = SweepClustering(*grid,
                                  ClusteringParameters(),
                                  Sequences(*input, true, kSweptSequences),
                                  results.wrong_mode_deg,
                                  arguments.threads,
                                  interrupt.token());
  if (interrupt.token().stop_requested()) return kInterrupted;
  MeasureGrids(arguments.largest_grid, &results);

  if (const auto written = WriteEvaluation(results, folder); !written) return written.error();
  std::printf("%s%s\n", AccuracyText(results).c_str(), (folder / "report.html").c_str());
  if (!arguments.check) return 0;
  const std::vector<std::string> missed = MissedBars(results);
  for (const std::string& bar : missed) std::fprintf(stderr, "%s\n", bar.c_str());
  return missed.empty() ? 0 : 1;
}

/// @return the exit code.
Result<int> EvaluateConfusions(const Arguments& arguments) {
  const Interrupt interrupt("the work begun");
  const fs::path folder =
      fs::path(arguments.output) / (arguments.name.empty() ? "confusion" : arguments.name);
  if (const auto prepared = PrepareOutput(folder); !prepared) return prepared.error();
  const ConfusionRequest request{arguments.use,
                                 arguments.models,
                                 fs::path(arguments.output) / "cache",
                                 arguments.sequences,
                                 arguments.views,
                                 arguments.seed,
                                 arguments.threads};
  ConfusionResults results;
  results.command = "vantage-evaluate --confusion" + OptionsText(arguments);
  results.version = VANTAGE_VERSION;
  const ConfusionProgress progress = [](const std::string& what) {
    const auto bar = std::make_shared<ShownProgress>(what);
    return [bar](int64_t done, int64_t total) { bar->Show(done, total); };
  };
  const Result<bool> is_complete =
      EvaluateConfusion(request, interrupt.token(), progress, &results);
  if (!is_complete) return is_complete.error();
  if (!*is_complete) return kInterrupted;
  if (const auto written = WriteConfusionReport(results, folder); !written) {
    return written.error();
  }
  std::printf("%s%s\n", ConfusionText(results).c_str(), (folder / "report.html").c_str());
  if (!arguments.check) return 0;
  const std::vector<std::string> missed = MissedBars(results);
  for (const std::string& bar : missed) std::fprintf(stderr, "%s\n", bar.c_str());
  return missed.empty() ? 0 : 1;
}

/// @return the exit code.
Result<int> EvaluateHandEyes(const Arguments& arguments) {
  if (arguments.sequences == 0) {
    return Error{ErrorCode::kInvalidArgument, "--sequences = 0, expected at least 1 trial"};
  }
  const Interrupt interrupt("the trial in work");
  const fs::path folder =
      fs::path(arguments.output) / (arguments.name.empty() ? "handeye" : arguments.name);
  if (const auto prepared = PrepareOutput(folder); !prepared) return prepared.error();
  HandEyeResults results;
  results.command = Format("vantage-evaluate --handeye --sequences %d --seed %llu",
                           arguments.sequences,
                           static_cast<unsigned long long>(arguments.seed));
  results.version = VANTAGE_VERSION;
  {
    ShownProgress bar("calibrations");
    const bool is_complete = EvaluateHandEye(
        {arguments.sequences, arguments.seed},
        interrupt.token(),
        [&bar](int64_t done, int64_t total) { bar.Show(done, total); },
        &results);
    if (!is_complete) return kInterrupted;
  }
  if (const auto written = WriteHandEyeReport(results, folder); !written) return written.error();
  std::printf("%s%s\n", HandEyeText(results).c_str(), (folder / "report.html").c_str());
  if (!arguments.check) return 0;
  const std::vector<std::string> missed = MissedBars(results);
  for (const std::string& bar : missed) std::fprintf(stderr, "%s\n", bar.c_str());
  return missed.empty() ? 0 : 1;
}

/// @return the exit code.
Result<int> EvaluateRefinement(const Arguments& arguments) {
  const Interrupt interrupt("the sequence in work");
  const fs::path folder =
      fs::path(arguments.output) / (arguments.name.empty() ? "refinement" : arguments.name);
  if (const auto prepared = PrepareOutput(folder); !prepared) return prepared.error();
  const Result<std::vector<ObjectModel>> models = LoadModels(arguments);
  if (!models) return models.error();
  RefinementStudyResults results;
  results.command = "vantage-evaluate --refinement" + OptionsText(arguments);
  results.version = VANTAGE_VERSION;
  results.seed = arguments.seed;
  const RefinementRequest request{fs::path(arguments.output) / "cache",
                                  arguments.sequences,
                                  arguments.views,
                                  arguments.seed,
                                  arguments.threads};
  {
    ShownProgress bar("sequences refined");
    const Result<bool> is_complete = StudyRefinement(
        *models,
        request,
        interrupt.token(),
        [&bar](int64_t done, int64_t total) { bar.Show(done, total); },
        &results);
    if (!is_complete) return is_complete.error();
    if (!*is_complete) return kInterrupted;
  }
  if (!arguments.turntable.empty()) {
    results.command += " --turntable " + arguments.turntable;
    const fs::path meshes = arguments.meshes.empty()
                                ? fs::path(arguments.turntable) / ".." / "meshes"
                                : fs::path(arguments.meshes);
    const Result<TurntableRefinement> turntable = RefineTurntable(arguments.turntable, meshes);
    if (!turntable) return turntable.error();
    results.turntable = *turntable;
  }
  if (const auto written = WriteRefinementReport(results, folder); !written) {
    return written.error();
  }
  std::printf("%s%s\n", RefinementText(results).c_str(), (folder / "report.html").c_str());
  const std::vector<std::string> missed = MissedBars(results);
  for (const std::string& bar : missed) std::fprintf(stderr, "%s\n", bar.c_str());
  return arguments.check && !missed.empty() ? 1 : 0;
}

std::string DatasetCommand(const Arguments& arguments) {
  std::string command = "vantage-evaluate --dataset " + arguments.dataset;
  if (!arguments.meshes.empty()) command += " --meshes " + arguments.meshes;
  return command + Format(" --estimator %s --seed %llu",
                          arguments.estimator.c_str(),
                          static_cast<unsigned long long>(arguments.seed));
}

/// All datasets of the folder; those that can't be evaluated become notes unless there is no other.
Result<void> LoadDatasets(const Arguments& arguments, DatasetResults* results) {
  const Result<std::vector<fs::path>> folders = FindDatasets(arguments.dataset);
  if (!folders) return folders.error();
  for (const fs::path& folder : *folders) {
    const std::optional<std::string> why_not = WhyNotEvaluated(folder);
    if (why_not && folders->size() > 1) {
      results->notes.push_back(*why_not + ".");
      continue;
    }
    const fs::path meshes =
        arguments.meshes.empty() ? folder / ".." / "meshes" : fs::path(arguments.meshes);
    Result<Dataset> dataset = LoadDataset(folder, meshes);
    if (!dataset) return dataset.error();
    results->datasets.push_back(std::move(dataset).value());
  }
  return {};
}

/// @return the exit code.
Result<int> EvaluateDatasets(const Arguments& arguments) {
  const Interrupt interrupt("the sequences in work");
  const Result<std::vector<std::string>> estimators = FindEstimators(arguments.estimator);
  if (!estimators) return estimators.error();
  DatasetResults results;
  results.command = DatasetCommand(arguments);
  results.version = VANTAGE_VERSION;
  results.seed = arguments.seed;
  if (const auto loaded = LoadDatasets(arguments, &results); !loaded) return loaded.error();
  {
    ShownProgress bar("images");
    const Result<bool> is_complete = RunDatasets(
        *estimators,
        MakeEstimator,
        interrupt.token(),
        [&bar](int64_t done, int64_t total) { bar.Show(done, total); },
        &results);
    if (!is_complete) return is_complete.error();
    if (!*is_complete) return kInterrupted;
  }
  const fs::path folder =
      fs::path(arguments.output) / (arguments.name.empty() ? "dataset" : arguments.name);
  if (const auto written = WriteDatasetReport(results, folder); !written) return written.error();
  std::printf("%s%s\n", DatasetText(results).c_str(), (folder / "report.html").c_str());
  const std::vector<std::string> missed = MissedBars(results);
  for (const std::string& bar : missed) std::fprintf(stderr, "%s\n", bar.c_str());
  return arguments.check && !missed.empty() ? 1 : 0;
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Regenerates the paper's Tables 1 and 2 and Figures 4, 8, 10, 14 and 15 with simulated views "
      "and the real estimator, and compares every fusion method on the same detections; or Table 3 "
      "and Figures 5, 6 and 16 to 18 with measured contingency tables, and how many views every "
      "way to choose the next one needs. What takes long is cached: an interrupted run goes on "
      "where it ended. Or evaluates estimators on single views of real datasets, hand-eye "
      "calibration against OpenCV's, or the refinement over several views.",
      "vantage-evaluate");
  Arguments arguments;
  CLI::Option_group* work = app.add_option_group("what to do");
  work->add_flag("--paper", arguments.paper, "What the paper shows of fusion");
  work->add_flag("--confusion",
                 arguments.confusion,
                 "What it shows of contingency tables and next views, and views needed");
  work->add_flag("--tune",
                 arguments.tune,
                 "Tries parameters of every method on sequences of the seed plus 1000");
  work->add_flag(
      "--handeye", arguments.handeye, "Hand-eye calibration from simulated poses against OpenCV's");
  work->add_flag("--refinement",
                 arguments.refinement,
                 "Poses from the depth of all views together, beside the fused ones");
  work->add_option("--dataset",
                   arguments.dataset,
                   "Evaluates estimators on real views: a folder of a dataset, or of several");
  work->require_option(1);
  app.add_option(
      "--meshes", arguments.meshes, "Meshes of the datasets, by default DATASET/../meshes");
  app.add_option("--turntable",
                 arguments.turntable,
                 "Real views of an object on a turntable that --refinement takes too: a folder");
  app.add_option("--estimator", arguments.estimator, "One of them, or all, on the datasets")
      ->capture_default_str();
  app.add_option("--method", arguments.methods, "Methods to tune, by id; all of them by default");
  // tools/paper names these two; its user may name others.
  const auto last = CLI::MultiOptionPolicy::TakeLast;
  app.add_option("--models", arguments.models, "Folder with one folder a model")
      ->multi_option_policy(last)
      ->capture_default_str();
  app.add_option("--use",
                 arguments.use,
                 "Models of that folder, by default all of them; with --confusion also generated "
                 "objects, by default those that look alike from several sides");
  app.add_option("--sequences",
                 arguments.sequences,
                 "Random sequences of each model, by default 60, 40 with --confusion, or 10 to "
                 "tune on; trials of each cell with --handeye, by default 1000")
      ->check(CLI::Range(0, 100000));
  app.add_option("--views",
                 arguments.views,
                 "Views of a random sequence, by default 12, or 15 with --confusion")
      ->check(CLI::Range(1, 1000));
  app.add_option("--seed", arguments.seed, "Of all that is random")
      ->check(CLI::Range(int64_t{0}, INT64_MAX))
      ->capture_default_str();
  app.add_option("--threads", arguments.threads, "They change the time alone; 0: one a processor")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--k", arguments.k, "Divisions of the histogram's grid")
      ->check(CLI::Range(So3Grid::kSmallest, So3Grid::kLargest))
      ->capture_default_str();
  app.add_option("--largest-grid", arguments.largest_grid, "Largest k in Table 1")
      ->check(CLI::Range(0, So3Grid::kLargest))
      ->capture_default_str();
  app.add_option("--output", arguments.output, "Folder of the cache and the reports")
      ->multi_option_policy(last)
      ->capture_default_str();
  app.add_option("--name",
                 arguments.name,
                 "The report goes to OUTPUT/NAME, by default paper, confusion, dataset, handeye "
                 "or refinement");
  app.add_flag("--check", arguments.check, "Exit with 1 where a bar is missed");
  if (const auto code = ParseCommandLine(app, argc, argv)) return *code;
  if (arguments.threads == 0) {
    arguments.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }
  if (arguments.sequences < 0) {
    arguments.sequences = arguments.tune         ? kTuningSequences
                          : arguments.confusion  ? kConfusionSequences
                          : arguments.refinement ? kRefinementSequences
                          : arguments.handeye    ? kHandEyeTrials
                                                 : kEvaluationSequences;
  }
  if (arguments.views < 0) {
    arguments.views = arguments.confusion ? kConfusionViews : kEvaluationViews;
  }
  const Result<int> code = !arguments.dataset.empty() ? EvaluateDatasets(arguments)
                           : arguments.tune           ? Tune(arguments)
                           : arguments.confusion      ? EvaluateConfusions(arguments)
                           : arguments.handeye        ? EvaluateHandEyes(arguments)
                           : arguments.refinement     ? EvaluateRefinement(arguments)
                                                      : Evaluate(arguments);
  if (code) return *code;
  std::fprintf(stderr, "vantage-evaluate: %s\n", code.error().message.c_str());
  return 2;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Main(argc, argv); }
