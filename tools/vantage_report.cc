// vantage-report: judges a recorded run against the truth and makes a page of it.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "common/format.h"
#include "nodes/command_line.h"
#include "tools/support/png_image.h"
#include "tools/support/recorded_run.h"
#include "tools/support/report_page.h"
#include "tools/support/report_pictures.h"
#include "tools/support/report_setup.h"
#include "tools/support/run_metrics.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string log;
  std::string config;
  std::string output;
  std::string truth;
  std::string truth_model;
  std::string title = "Vantage run";
  ReportLimits limits;
  bool per_view = false;
  bool better_than_median = false;
  bool check = false;
};

Result<void> WriteFiles(const Arguments& arguments,
                        const RecordedRun& run,
                        const ReportSetup& setup,
                        const RunMetrics& metrics) {
  const Result<std::string> page =
      ReportPage(arguments.title, run, setup, metrics, arguments.limits);
  if (!page) return page.error();
  const fs::path folder = arguments.output;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("folder %s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  if (Result<void> written =
          WritePng(folder / "report_scene.png", ScenePicture(run, setup, SceneCut::kObjects));
      !written) {
    return written;
  }
  if (Result<void> written = WriteWholeFile(folder / "report_errors.csv", ErrorsCsv(metrics));
      !written) {
    return written;
  }
  if (Result<void> written =
          WriteWholeFile(folder / "report.json", ReportJson(metrics, arguments.limits));
      !written) {
    return written;
  }
  return WriteWholeFile(folder / "report.html", *page);
}

/// @return whether the run is within the limits.
Result<bool> Report(const Arguments& arguments) {
  Result<ReportSetup> setup = LoadReportSetup(arguments.config);
  if (!setup) return setup.error();
  if (!arguments.truth.empty()) {
    const Result<TruthObject> truth = ReadTruthMatrix(arguments.truth, arguments.truth_model);
    if (!truth) return truth.error();
    if (!setup->models.contains(truth->model_id)) {
      return Error{ErrorCode::kNotFound,
                   Format("--truth-model %s is no model of [models] in %s",
                          truth->model_id.c_str(),
                          arguments.config.c_str())};
    }
    setup->truth = {*truth};
  }
  const Result<RecordedRun> run = ReadRun(arguments.log, setup->camera);
  if (!run) return run.error();
  const RunMetrics metrics = MeasureRun(*run, *setup);
  if (Result<void> written = WriteFiles(arguments, *run, *setup, metrics); !written) {
    return written.error();
  }
  if (arguments.per_view) std::printf("%s\n", ViewTable(metrics).c_str());
  std::printf("%s", SummaryTable(metrics, arguments.limits).c_str());
  if (arguments.better_than_median && !metrics.BetterThanMedianDetection()) {
    std::printf("an object's fused orientation is no better than its median single detection\n");
    return false;
  }
  return metrics.Within(arguments.limits.rotation_deg * kDegree,
                        1e-3 * arguments.limits.position_mm);
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Judges a recorded run and makes a page of it: report.html, report.json, "
      "report_errors.csv, report_scene.png",
      "vantage-report");
  app.add_option("log", arguments.log, "log with OBJECTS and what they were made from")->required();
  app.add_option("--config,-c", arguments.config, "TOML file of the set-up; its [sim] is the truth")
      ->required();
  app.add_option("--output,-o", arguments.output, "folder to write to")->required();
  CLI::Option* truth =
      app.add_option("--truth", arguments.truth, "file with T_world_object, 4 x 4");
  app.add_option("--truth-model", arguments.truth_model, "which model --truth is of")->needs(truth);
  truth->needs("--truth-model");
  app.add_option("--title", arguments.title, "of the page");
  app.add_option("--max-rotation-deg", arguments.limits.rotation_deg, "limit for --check")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--max-position-mm", arguments.limits.position_mm, "limit for --check")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_flag("--per-view", arguments.per_view, "print every view's errors");
  app.add_flag("--better-than-median",
               arguments.better_than_median,
               "let --check fail, too, where an object's median single detection is as good");
  app.add_flag("--check", arguments.check, "exit 1 when an object is missed, wrong or not there");
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  const vantage::Result<bool> within = vantage::Report(arguments);
  if (!within) {
    std::fprintf(stderr, "vantage-report: %s\n", within.error().message.c_str());
    return 2;
  }
  return arguments.check && !*within ? 1 : 0;
}
