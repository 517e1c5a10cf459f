// Regenerates the paper's evaluation: simulated views, the real estimator, every fusion method on
// the same detections, a report.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/format.h"
#include "common/result.h"
#include "fusion/so3_grid.h"
#include "nodes/command_line.h"
#include "nodes/models_config.h"
#include "perception/model/object_model.h"
#include "tools/evaluate/clustering_sweep.h"
#include "tools/evaluate/detection_run.h"
#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/fusion_methods.h"
#include "tools/evaluate/grid_statistics.h"
#include "tools/evaluate/progress_bar.h"
#include "tools/evaluate/report_writer.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  bool paper = false;
  std::string models = "models";
  std::vector<std::string> use;
  std::string output = "out/evaluate";
  std::string name = "paper";
  int sequences = 60;
  int views = 12;
  uint64_t seed = 1;
  int threads = 0;
  int k = 32;
  int largest_grid = 64;
  bool check = false;
};

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A progress bar that appears with the first step.
class Progress {
 public:
  explicit Progress(std::string what) : what_(std::move(what)) {}
  ~Progress() {
    if (bar_) bar_->Finish();
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Show(int64_t done, int64_t total) {
    if (!bar_) {
      bar_ =
          std::make_unique<ProgressBar>(std::cerr, what_, total, isatty(STDERR_FILENO) != 0, Now());
    }
    bar_->Show(done, Now());
  }

 private:
  std::string what_;
  std::unique_ptr<ProgressBar> bar_;
};

/// Turns SIGINT and SIGTERM into a stop request; a second one ends the program at once. Made before
/// any thread.
class Interrupt {
 public:
  Interrupt() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    std::thread([signals = signals_, source = source_]() mutable {
      int signal = 0;
      sigwait(&signals, &signal);
      std::fprintf(stderr, "\nending after the sequences in work; once more to end at once\n");
      source.request_stop();
      sigwait(&signals, &signal);
      _exit(128 + signal);
    }).detach();
  }
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  sigset_t signals_{};
  std::stop_source source_;
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

Result<DetectionRun> Detect(const std::vector<ObjectModel>& models,
                            const Arguments& arguments,
                            const std::stop_token& stop) {
  DetectionRequest request;
  request.simulation.seed = arguments.seed;
  request.simulation.views.random_views = arguments.views;
  request.random_sequences = arguments.sequences;
  request.threads = arguments.threads;
  request.cache = fs::path(arguments.output) / "cache";
  Progress bar("views");
  return RunDetections(models, request, stop, [&bar](const DetectionProgress& progress) {
    bar.Show(progress.views_done, progress.views_total);
  });
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

void PrintAccuracy(const EvaluationResults& results) {
  size_t num_sequences = 0;
  for (const SequenceErrors& model : results.sequences) {
    num_sequences += model.final_deg.front().size();
  }
  std::printf("%zu sequences of %d views, %zu objects; errors modulo symmetry, 95 %% intervals\n",
              num_sequences,
              results.views_per_sequence,
              results.sequences.size());
  std::printf("%-26s %-26s %-22s %-28s %s\n",
              "method",
              "median (deg)",
              "wrong mode (%)",
              "median less the best's (deg)",
              "us a view");
  for (size_t m = 0; m < results.accuracy.size(); ++m) {
    const MethodAccuracy& accuracy = results.accuracy[m];
    const auto interval = [](const Interval& i, double unit, int digits) {
      return Format(
          "%.*f (%.*f..%.*f)", digits, unit * i.value, digits, unit * i.low, digits, unit * i.high);
    };
    std::printf("%-26s %-26s %-22s %-28s %.0f\n",
                results.methods[m].label.c_str(),
                interval(accuracy.median_deg, 1.0, 4).c_str(),
                interval(accuracy.wrong_mode_rate, 100.0, 2).c_str(),
                interval(accuracy.difference_of_medians_deg, 1.0, 4).c_str(),
                1e6 * accuracy.seconds_per_view);
  }
}

std::string CommandText(const Arguments& arguments) {
  std::string command = "vantage-evaluate --paper";
  command += Format(" --models %s", arguments.models.c_str());
  for (const std::string& name : arguments.use) command += " --use " + name;
  command += Format(" --sequences %d --views %d --seed %llu --k %d",
                    arguments.sequences,
                    arguments.views,
                    static_cast<unsigned long long>(arguments.seed),
                    arguments.k);
  return command;
}

/// @return the exit code.
Result<int> Evaluate(const Arguments& arguments) {
  const Interrupt interrupt;
  const Result<So3Grid> grid = So3Grid::Create(arguments.k);
  if (!grid) return grid.error();
  EvaluationParameters parameters;
  parameters.seed = arguments.seed;
  parameters.threads = arguments.threads;
  parameters.figure10_models = {"filter", "hub", "bracket"};
  if (const auto valid = parameters.Validate(); !valid) return valid.error();
  const Result<std::vector<ObjectModel>> models = LoadModels(arguments);
  if (!models) return models.error();

  const Result<DetectionRun> run = Detect(*models, arguments, interrupt.token());
  if (!run) return run.error();
  for (const std::string& note : run->notes) std::fprintf(stderr, "%s\n", note.c_str());
  std::fprintf(stderr,
               "%lld views simulated, %lld from the cache\n",
               static_cast<long long>(run->views_made),
               static_cast<long long>(run->views_reused));
  constexpr int kInterrupted = 130;
  if (!run->is_complete) return kInterrupted;

  EvaluationResults results;
  results.command = CommandText(arguments);
  results.version = VANTAGE_VERSION;
  results.views_per_sequence = arguments.views;
  results.histogram_k = arguments.k;
  const std::vector<FusionMethod> methods = FusionMethods(*grid);
  {
    Progress bar("sequences fused");
    if (!EvaluateMethods(
            *models,
            run->models,
            methods,
            parameters,
            interrupt.token(),
            [&bar](int64_t done, int64_t total) { bar.Show(done, total); },
            &results)) {
      return kInterrupted;
    }
  }
  std::vector<EvaluatedSequence> all;
  for (size_t i = 0; i < models->size(); ++i) {
    for (const auto& s : run->models[i].circles) all.push_back({&s, &(*models)[i].symmetry});
    for (const auto& s : run->models[i].random) all.push_back({&s, &(*models)[i].symmetry});
  }
  results.sweep =
      SweepClustering(*grid, all, results.wrong_mode_deg, arguments.threads, interrupt.token());
  if (interrupt.token().stop_requested()) return kInterrupted;
  MeasureGrids(arguments.largest_grid, &results);

  const fs::path folder = fs::path(arguments.output) / arguments.name;
  if (const auto written = WriteEvaluation(results, folder); !written) return written.error();
  PrintAccuracy(results);
  std::printf("%s\n", (folder / "report.html").c_str());
  if (!arguments.check) return 0;
  const std::vector<std::string> missed = MissedBars(results);
  for (const std::string& bar : missed) std::fprintf(stderr, "%s\n", bar.c_str());
  return missed.empty() ? 0 : 1;
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Regenerates the paper's Tables 1 and 2 and Figures 4, 8, 10, 14 and 15 with simulated views "
      "and the real estimator, and compares every fusion method on the same detections. Detections "
      "are cached: an interrupted run goes on where it ended.",
      "vantage-evaluate");
  Arguments arguments;
  app.add_flag("--paper", arguments.paper, "Everything that the paper shows")->required();
  app.add_option("--models", arguments.models, "Folder with one folder a model")
      ->capture_default_str();
  app.add_option("--use", arguments.use, "Models of that folder; all of them by default");
  app.add_option("--sequences", arguments.sequences, "Random sequences of each model")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  app.add_option("--views", arguments.views, "Views of a random sequence")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--seed", arguments.seed, "Of all that is random")->capture_default_str();
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
      ->capture_default_str();
  app.add_option("--name", arguments.name, "The report goes to OUTPUT/NAME")->capture_default_str();
  app.add_flag("--check", arguments.check, "Exit with 1 where the best variant of ours is not");
  if (const auto code = ParseCommandLine(app, argc, argv)) return *code;
  if (arguments.threads == 0) {
    arguments.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }
  const Result<int> code = Evaluate(arguments);
  if (code) return *code;
  std::fprintf(stderr, "vantage-evaluate: %s\n", code.error().message.c_str());
  return 2;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Main(argc, argv); }
