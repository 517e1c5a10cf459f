// Measures by simulated trials which orientations of an object an estimator takes for which: the
// contingency table of the paper's section 6, by viewing direction and by rows.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/format.h"
#include "common/result.h"
#include "fusion/confusion/contingency_file.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/so3_grid.h"
#include "nodes/command_line.h"
#include "nodes/confusion_config.h"
#include "tools/contingency/left_invariance.h"
#include "tools/contingency/measure_table.h"
#include "tools/contingency/table_text.h"
#include "tools/contingency/trial_setup.h"
#include "tools/contingency/trial_units.h"
#include "tools/contingency/work_file.h"
#include "tools/support/interrupt.h"
#include "tools/support/shown_progress.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kNamedMissing = 20;  // Ranges of directions in a message.
// From so many directions on, four and more lie within 5 degrees of any one and lend it their
// trials (ConfusionModel): each may then be content with less of its own, 24 trials that agree in
// place of 69.
constexpr int kDense = 2500;
constexpr double kConfusionOfDense = 0.2;  // StoppingParameters::largest_confusion

struct Arguments {
  // Of measure and test.
  std::string model;
  std::string estimator = "ppf";
  std::string config;
  int threads = 0;  // 0: one a processor.
  // Of measure.
  int k = 8;
  int directions = -1;  // Below 0: as many as suit k.
  std::string rows;
  int trials = 0;  // 0: until they are enough.
  uint64_t seed = 1;
  std::string shard = "1/1";
  std::string output;  // Of merge, too.
  // Of merge, show and test.
  std::vector<std::string> parts;
  bool allow_incomplete = false;
  std::string table;
  bool csv = false;
  LeftInvarianceParameters test;
};

Error InvalidArgument(std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message)};
}

/// The model, how it is looked at, and where its table belongs.
struct Setup {
  ObjectModel model;
  TrialParameters parameters;
  fs::path file;
};

Result<Setup> MakeSetup(const Arguments& arguments, const std::string& file, const char* option) {
  Setup setup;
  Result<TrialParameters> parameters = ReadTrialParameters(arguments.estimator, arguments.config);
  if (!parameters) return parameters.error();
  setup.parameters = std::move(parameters).value();
  Result<ObjectModel> model = FindTrialModel(arguments.model);
  if (!model) return model.error();
  setup.model = std::move(model).value();
  setup.file = file;
  if (!file.empty()) return setup;
  if (!fs::is_directory(arguments.model)) {
    return InvalidArgument(Format(
        "%s is no folder to keep the table in, expected %s FILE", arguments.model.c_str(), option));
  }
  setup.file = fs::path(arguments.model) / ConfusionFileName(arguments.estimator);
  return setup;
}

Result<TrialPlan> MakePlan(const Arguments& arguments,
                           const ObjectModel& model,
                           int num_directions) {
  TrialPlan plan{model.id, arguments.seed, model.symmetry, {}};
  if (arguments.trials > 0) {
    plan.stopping.least_trials = arguments.trials;
    plan.stopping.most_trials = arguments.trials;
  } else if (num_directions >= kDense) {
    plan.stopping.largest_confusion = kConfusionOfDense;
  }
  if (Result<void> valid = plan.stopping.Validate(); !valid) return valid.error();
  return plan;
}

Result<TrialUnits> AllUnits(const Arguments& arguments, int num_directions) {
  TrialUnits all;
  for (int i = 0; i < num_directions; ++i) all.directions.push_back(i);
  if (!arguments.rows.empty()) {
    Result<std::vector<int32_t>> rows =
        ParseRows(arguments.rows, So3Grid(arguments.k).num_cells(), arguments.seed);
    if (!rows) return rows.error();
    all.rows = std::move(rows).value();
  }
  if (num_directions == 1) {
    return InvalidArgument("--directions 1, expected 0 or at least 2");
  }
  if (all.size() == 0) {
    return InvalidArgument("--directions 0 and no --rows, expected something to measure");
  }
  return all;
}

/// What an earlier run completed; an empty table where there is none. Errors: another table is
/// there.
Result<ContingencyTable> ReadEarlier(const fs::path& file, const ContingencyKey& key) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    ContingencyTable none;
    none.key = key;
    return none;
  }
  Result<ContingencyTable> table = ReadContingencyTable(file);
  if (!table) return table;
  const std::string difference = table->key.DifferenceFrom(key);
  if (difference.empty()) return table;
  return InvalidArgument(
      Format("%s is of another measurement: its %s; remove it or name another "
             "--output",
             file.c_str(),
             difference.c_str()));
}

TrialUnits NotIn(const ContingencyTable& table, const TrialUnits& units) {
  TrialUnits rest;
  for (const int32_t direction : units.directions) {
    const auto place = static_cast<size_t>(direction);
    const bool is_there = place < table.directions.size() && table.directions[place].trials > 0;
    if (!is_there) rest.directions.push_back(direction);
  }
  for (const int32_t row : units.rows) {
    if (!table.rows.contains(row)) rest.rows.push_back(row);
  }
  return rest;
}

void PrintWritten(const fs::path& file, const ContingencyTable& table) {
  std::error_code ignored;
  const size_t missing = MissingDirections(table).size();
  std::printf("%s: %jd trials, %zu of %d directions, %zu rows, %.2f MB\n",
              file.c_str(),
              intmax_t{table.NumTrials()},
              static_cast<size_t>(table.key.num_directions) - missing,
              table.key.num_directions,
              table.rows.size(),
              1e-6 * static_cast<double>(fs::file_size(file, ignored)));
}

/// @return the exit code.
Result<int> Measure(const Arguments& arguments) {
  const Interrupt interrupt("the directions in work");
  const Result<Shard> shard = ParseShard(arguments.shard);
  if (!shard) return shard.error();
  const int num_directions =
      arguments.directions < 0 ? NumDirections(arguments.k) : arguments.directions;
  const Result<TrialUnits> all = AllUnits(arguments, num_directions);
  if (!all) return all.error();
  const Result<Setup> setup = MakeSetup(arguments, arguments.output, "--output");
  if (!setup) return setup.error();
  const Result<TrialPlan> plan = MakePlan(arguments, setup->model, num_directions);
  if (!plan) return plan.error();
  const ContingencyKey key =
      MakeKey(setup->model, setup->parameters, *plan, num_directions, arguments.k);
  const Result<ContingencyTable> earlier = ReadEarlier(setup->file, key);
  if (!earlier) return earlier.error();
  const TrialUnits units = NotIn(*earlier, UnitsOf(*shard, *all));

  Result<WorkFile> work = WorkFile::Open(setup->file.string() + ".trials", key);
  if (!work) return work.error();
  {
    ShownProgress bar("directions and rows");
    const Result<bool> is_complete = MeasureTable(
        *plan,
        units,
        arguments.threads,
        SimulatedDetectors(setup->model, setup->parameters),
        interrupt.token(),
        [&bar](const MeasureProgress& progress) {
          bar.Show(progress.units_done, progress.units_total);
        },
        &*work);
    if (!is_complete) return is_complete.error();
    if (!*is_complete) return kInterrupted;
  }
  const Result<ContingencyTable> table = MergeTables({*earlier, work->table()});
  if (!table) return table.error();
  if (Result<void> written = WriteContingencyTable(*table, setup->file); !written) {
    return written.error();
  }
  if (Result<void> removed = work->Remove(); !removed) return removed.error();
  PrintWritten(setup->file, *table);
  return 0;
}

/// @return the exit code.
Result<int> Merge(const Arguments& arguments) {
  std::vector<ContingencyTable> parts;
  for (const std::string& part : arguments.parts) {
    Result<ContingencyTable> table = ReadContingencyTable(part);
    if (!table) return table.error();
    const std::string difference =
        parts.empty() ? "" : table->key.DifferenceFrom(parts.front().key);
    if (!difference.empty()) {
      return InvalidArgument(Format("%s is not of the same table as %s: its %s",
                                    part.c_str(),
                                    arguments.parts.front().c_str(),
                                    difference.c_str()));
    }
    parts.push_back(std::move(table).value());
  }
  const Result<ContingencyTable> whole = MergeTables(parts);
  if (!whole) return whole.error();
  const std::vector<int32_t> missing = MissingDirections(*whole);
  if (!missing.empty() && !arguments.allow_incomplete) {
    return InvalidArgument(
        Format("%zu of %d directions are in no part: %s; expected all of them, "
               "or --allow-incomplete",
               missing.size(),
               whole->key.num_directions,
               RangesText(missing, kNamedMissing).c_str()));
  }
  const Result<ContingencyTable> earlier = ReadEarlier(arguments.output, whole->key);
  if (!earlier) return earlier.error();
  if (Result<void> written = WriteContingencyTable(*whole, arguments.output); !written) {
    return written.error();
  }
  PrintWritten(arguments.output, *whole);
  return 0;
}

/// @return the exit code.
Result<int> Show(const Arguments& arguments) {
  const Result<ContingencyTable> table = ReadContingencyTable(arguments.table);
  if (!table) return table.error();
  std::error_code ignored;
  const std::string text =
      arguments.csv ? TableCsv(*table) : TableText(*table, fs::file_size(arguments.table, ignored));
  std::fputs(text.c_str(), stdout);
  return 0;
}

/// @return the exit code.
Result<int> Test(const Arguments& arguments) {
  const Interrupt interrupt("the trials in work");
  const Result<Setup> setup = MakeSetup(arguments, arguments.table, "--table");
  if (!setup) return setup.error();
  const Result<ContingencyTable> table = ReadContingencyTable(setup->file);
  if (!table) return table.error();
  const ContingencyKey expected = MakeKey(setup->model, setup->parameters, {}, 0, 0);
  if (Result<void> fits = CheckContingencyKey(table->key, expected, setup->file.string()); !fits) {
    return fits.error();
  }
  ShownProgress bar("tests");
  const Result<std::optional<LeftInvarianceReport>> report =
      TestLeftInvariance(*table,
                         setup->model.symmetry,
                         arguments.test,
                         arguments.threads,
                         SimulatedDetectors(setup->model, setup->parameters),
                         interrupt.token(),
                         [&bar](int64_t done, int64_t total) { bar.Show(done, total); });
  if (!report) return report.error();
  if (!report->has_value()) return kInterrupted;
  const std::string text = ReportText(**report);
  for (const auto& [suffix, content] :
       {std::pair{".report.txt", text}, std::pair{".report.json", ReportJson(**report)}}) {
    if (auto written = WriteWholeFile(setup->file.string() + suffix, content); !written) {
      return written.error();
    }
  }
  std::fputs(text.c_str(), stdout);
  return 0;
}

void AddModelOptions(CLI::App* command, Arguments* arguments) {
  command
      ->add_option("model", arguments->model, "a model's folder, or the name of a generated object")
      ->required();
  command->add_option("--estimator", arguments->estimator, "ppf or shot")
      ->check(CLI::IsMember({"ppf", "shot"}))
      ->capture_default_str();
  command->add_option(
      "--config", arguments->config, "the processes' configuration, for estimator and sensor");
  command
      ->add_option(
          "--threads", arguments->threads, "they change the time alone; one a processor by default")
      ->check(CLI::Range(1, 1024));
}

void AddMeasure(CLI::App* command, Arguments* arguments) {
  AddModelOptions(command, arguments);
  command
      ->add_option("--k", arguments->k, "divisions of the grid of rows; as finely lie directions")
      ->check(CLI::Range(So3Grid::kSmallest, So3Grid::kLargest))
      ->capture_default_str();
  command
      ->add_option("--directions",
                   arguments->directions,
                   "cells of viewing directions instead; 0: rows alone")
      ->check(CLI::Range(0, DirectionGrid::kMost));
  command->add_option(
      "--rows", arguments->rows, "rows as the paper measures them: 0,17,100-140 or random:20");
  command
      ->add_option(
          "--trials",
          arguments->trials,
          Format("always so many, not until they are enough: until no outcome that was not "
                 "seen can have a share of %g, of %g from %d directions on, and the share "
                 "of every other is known to %g",
                 StoppingParameters{}.largest_confusion,
                 kConfusionOfDense,
                 kDense,
                 StoppingParameters{}.widest))
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--seed", arguments->seed, "of all that is random")
      ->check(CLI::Range(int64_t{0}, INT64_MAX))
      ->capture_default_str();
  command->add_option("--shard", arguments->shard, "I/N: the I-th of N parts alone")
      ->capture_default_str();
  command->add_option("--output", arguments->output, "by default MODEL/confusion-ESTIMATOR.bin");
}

void AddTest(CLI::App* command, Arguments* arguments) {
  AddModelOptions(command, arguments);
  command->add_option("--table", arguments->table, "by default MODEL/confusion-ESTIMATOR.bin");
  command->add_option("--directions", arguments->test.directions, "viewing directions to test")
      ->check(CLI::Range(0, DirectionGrid::kMost))
      ->capture_default_str();
  command->add_option("--rolls", arguments->test.rolls, "rolls to test each at")
      ->check(CLI::Range(1, 360))
      ->capture_default_str();
  command->add_option("--rows", arguments->test.rows, "rows to predict from their directions")
      ->check(CLI::Range(0, 100'000))
      ->capture_default_str();
}

/// "measure" may be left out.
std::vector<char*> WithCommand(int argc, char** argv) {
  static std::string measure = "measure";
  std::vector<char*> words(argv, argv + argc);
  const std::string first = argc > 1 ? argv[1] : "--help";
  const auto known = {"measure", "merge", "show", "test", "-h", "--help", "--version"};
  if (std::find(known.begin(), known.end(), first) == known.end()) {
    words.insert(words.begin() + 1, measure.data());
  }
  return words;
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Measures by simulated trials which orientations of an object an estimator takes for which.",
      "vantage-contingency");
  app.require_subcommand(1);
  Arguments arguments;
  CLI::App* measure =
      app.add_subcommand("measure", "make a table; an interrupted run goes on where it ended");
  AddMeasure(measure, &arguments);
  CLI::App* merge = app.add_subcommand("merge", "make one table of its shards");
  merge->add_option("output", arguments.output, "the table to write")->required();
  merge->add_option("parts", arguments.parts, "the shards' tables")->required();
  merge->add_flag("--allow-incomplete", arguments.allow_incomplete, "directions may be missing");
  CLI::App* show = app.add_subcommand("show", "print what a table holds");
  show->add_option("table", arguments.table, "the table")->required();
  show->add_flag("--csv", arguments.csv, "a line for each direction");
  CLI::App* test = app.add_subcommand(
      "test", "test what a table by direction assumes; writes TABLE.report.txt and .json");
  AddTest(test, &arguments);

  std::vector<char*> words = WithCommand(argc, argv);
  if (const auto code = ParseCommandLine(app, static_cast<int>(words.size()), words.data())) {
    return *code;
  }
  if (arguments.threads == 0) {
    arguments.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  }
  const Result<int> code = *measure ? Measure(arguments)
                           : *merge ? Merge(arguments)
                           : *show  ? Show(arguments)
                                    : Test(arguments);
  if (code) return *code;
  std::fprintf(stderr, "vantage-contingency: %s\n", code.error().message.c_str());
  return 2;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Main(argc, argv); }
