// Finds where a camera is fixed to a robot's hand or beside it: hand-eye calibration.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "common/result.h"
#include "nodes/command_line.h"
#include "tools/handeye/calibrate_command.h"
#include "tools/handeye/draw_target_command.h"
#include "tools/handeye/live_command.h"
#include "tools/handeye/suggest_command.h"

namespace vantage {
namespace {

int Run(int argc, char** argv) {
  CLI::App app("Finds where a camera is fixed to a robot's hand or beside it.", "vantage-handeye");
  app.require_subcommand(1);
  CalibrateCommand calibrate(&app);
  DrawTargetCommand draw_target(&app);
  LiveCommand live(&app);
  SuggestCommand suggest(&app);
  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  const Result<int> done = calibrate.IsChosen()     ? calibrate.Run()
                           : draw_target.IsChosen() ? draw_target.Run()
                           : live.IsChosen()        ? live.Run()
                                                    : suggest.Run();
  if (!done) {
    std::fprintf(stderr, "vantage-handeye: %s\n", done.error().message.c_str());
    return 2;
  }
  return *done;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
