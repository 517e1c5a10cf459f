// Makes, looks into, mends and takes apart LCM event logs.

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <optional>

#include "common/result.h"
#include "nodes/command_line.h"
#include "tools/log/check_command.h"
#include "tools/log/compare_command.h"
#include "tools/log/cut_command.h"
#include "tools/log/export_command.h"
#include "tools/log/filter_command.h"
#include "tools/log/import_command.h"
#include "tools/log/info_command.h"
#include "tools/log/merge_command.h"
#include "tools/log/record_command.h"
#include "tools/log/repair_command.h"

namespace vantage {
namespace {

template <class... Commands>
Result<int> RunChosen(const Commands&... commands) {
  Result<int> done = 0;
  static_cast<void>(((commands.IsChosen() && (done = commands.Run(), true)) || ...));
  return done;
}

int Run(int argc, char** argv) {
  CLI::App app("Makes, looks into, mends and takes apart LCM event logs.", "vantage-log");
  app.require_subcommand(1);
  const InfoCommand info(&app);
  const RecordCommand record(&app);
  const CheckCommand check(&app);
  const RepairCommand repair(&app);
  const CompareCommand compare(&app);
  const CutCommand cut(&app);
  const FilterCommand filter(&app);
  const MergeCommand merge(&app);
  const ImportCommand import(&app);
  const ExportCommand export_files(&app);
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  std::signal(SIGXFSZ, SIG_IGN);  // A limit of a file's size shows as an error of write().
  const Result<int> done =
      RunChosen(info, record, check, repair, compare, cut, filter, merge, import, export_files);
  if (!done) {
    std::fprintf(stderr, "vantage-log: %s\n", done.error().message.c_str());
    return 2;
  }
  return *done;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
