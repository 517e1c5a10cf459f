// Makes, looks into, mends and takes apart LCM event logs.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "common/result.h"
#include "nodes/command_line.h"
#include "tools/log/import_command.h"
#include "tools/log/info_command.h"

namespace vantage {
namespace {

int Run(int argc, char** argv) {
  CLI::App app("Makes, looks into, mends and takes apart LCM event logs.", "vantage-log");
  app.require_subcommand(1);
  const ImportCommand import(&app);
  const InfoCommand info(&app);
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  const Result<int> done = import.IsChosen() ? import.Run() : info.Run();
  if (!done) {
    std::fprintf(stderr, "vantage-log: %s\n", done.error().message.c_str());
    return 2;
  }
  return *done;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
