#include "tools/replay/sweep_command.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "common/format.h"
#include "tools/replay/sweep_report.h"
#include "tools/support/shown_progress.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

Result<void> WriteFiles(const fs::path& folder,
                        const SweepGrid& grid,
                        const std::vector<std::string>& logs,
                        const std::vector<SweepCell>& cells) {
  const Result<std::string> figure = SweepFigure(grid, cells);
  if (!figure) return figure.error();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("folder %s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  for (const auto& [name, text] : {std::pair("sweep.csv", SweepCsv(grid, logs, cells)),
                                   std::pair("sweep.json", SweepJson(grid, logs, cells)),
                                   std::pair("sweep.svg", *figure)}) {
    if (Result<void> written = WriteWholeFile(folder / name, text); !written) return written;
  }
  return {};
}

}  // namespace

void AddSweepArguments(CLI::App* app, SweepArguments* arguments) {
  constexpr const char* kGroup = "Sweeping";
  CLI::Option* sweep =
      app->add_option(
             "--sweep",
             arguments->file,
             "TOML file with [grid] \"table.key\" = [values]: rerun with each combination, "
             "--threads at once; a table of errors, and --output is a folder")
          ->group(kGroup);
  app->add_option("more-logs", arguments->more_logs, "more logs, for --sweep")->needs(sweep);
  CLI::Option* truth =
      app->add_option("--truth",
                      arguments->truth,
                      "file with T_world_object, 4 x 4; default: [sim] of the configuration")
          ->group(kGroup)
          ->needs(sweep);
  CLI::Option* model =
      app->add_option("--truth-model", arguments->truth_model, "which model --truth is of")
          ->group(kGroup)
          ->needs(truth);
  truth->needs(model);
  for (const char* other : {"--compare", "--compare-with", "--with-inputs"}) {
    sweep->excludes(app->get_option(other));
  }
}

Result<void> Sweep(const SweepArguments& arguments, SweepOptions options) {
  const Result<SweepGrid> grid = ReadSweepGrid(arguments.file);
  if (!grid) return grid.error();
  options.logs = {options.replay.log};
  for (const std::string& log : arguments.more_logs) options.logs.push_back(log);
  options.truth = arguments.truth;
  options.truth_model = arguments.truth_model;
  const std::string folder = std::exchange(options.replay.output, "");
  Result<std::vector<SweepCell>> cells = [&] {
    ShownProgress progress("reruns");
    return RunSweep(
        options, *grid, [&](int64_t done, int64_t total) { progress.Show(done, total); });
  }();
  if (!cells) return cells.error();
  if (!folder.empty()) {
    if (Result<void> written = WriteFiles(folder, *grid, options.logs, *cells); !written) {
      return written;
    }
  }
  std::printf("%s", SweepTable(*grid, *cells).c_str());
  return {};
}

}  // namespace vantage
