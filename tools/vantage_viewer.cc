// vantage-viewer: shows a running set-up, or a log of one, in three dimensions.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "common/format.h"
#include "nodes/command_line.h"
#include "tools/viewer/log_player.h"
#include "tools/viewer/viewer_setup.h"
#include "tools/viewer/vtk/offscreen_view.h"
#include "tools/viewer/vtk/virtual_display.h"

namespace vantage {
namespace {

struct Arguments {
  std::string log;
  std::string config;
  std::string size = "1600x900";
  std::string at = "end";
  bool offscreen = false;
  OffscreenRequest request;
  ViewerOptions options;
  SceneCloud::Parameters cloud;
};

Result<void> View(const Arguments& arguments) {
  Result<ViewerSetup> setup = LoadViewerSetup(arguments.config, arguments.log);
  if (!setup) return setup.error();
  if (!setup->warning.empty()) {
    std::fprintf(stderr, "vantage-viewer: %s\n", setup->warning.c_str());
  }
  Result<std::unique_ptr<LogPlayer>> player = LogPlayer::Open(arguments.log, arguments.cloud);
  if (!player) return player.error();
  if (Result<void> surveyed = (*player)->Survey([](double) { return true; }); !surveyed) {
    return surveyed;
  }
  Result<VirtualDisplay> display =
      VirtualDisplay::Start(arguments.request.width, arguments.request.height);
  if (!display) return display.error();
  return DrawOffscreen(arguments.request, *setup, arguments.options, **player);
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("Shows a running set-up, or a log of one, in three dimensions", "vantage-viewer");
  app.add_option("log", arguments.log, "log of a run");
  app.add_option("--config,-c", arguments.config, "TOML file of the set-up");
  app.add_option("--output,-o", arguments.request.picture, "PNG file");
  app.add_option("--video", arguments.request.video, "video");
  app.add_option("--at", arguments.request.at, "s");
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  if (const vantage::Result<void> viewed = vantage::View(arguments); !viewed) {
    std::fprintf(stderr, "vantage-viewer: %s\n", viewed.error().message.c_str());
    return 2;
  }
  return 0;
}
