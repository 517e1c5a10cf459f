// vantage-viewer: shows a running set-up, or a log of one, in three dimensions.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bus/live_bus.h"
#include "common/format.h"
#include "nodes/command_line.h"
#include "tools/support/interrupt.h"
#include "tools/viewer/log_player.h"
#include "tools/viewer/viewer_keys.h"
#include "tools/viewer/viewer_setup.h"
#include "tools/viewer/vtk/offscreen_view.h"
#include "tools/viewer/vtk/virtual_display.h"
#include "tools/viewer/vtk/window_view.h"
#include "tools/viewer/window_page.h"

namespace vantage {
namespace {

constexpr int kMostPixels = 7680;  // Of a side.

struct Arguments {
  std::string log;
  std::string config;
  std::string lcm_url;
  bool offscreen = false;
  std::string size;
  std::string at;
  std::vector<double> vector;
  double voxel_mm = 4.0;
  OffscreenRequest request;
  ViewerOptions options;
  SceneCloud::Parameters cloud;
};

Error Refusal(const std::string& sentence) { return {ErrorCode::kInvalidArgument, sentence}; }

// Texts to numbers, and what does not go together.
Result<void> Complete(Arguments* arguments) {
  OffscreenRequest& request = arguments->request;
  char rest = 0;
  if (!arguments->size.empty() &&
      (std::sscanf(arguments->size.c_str(), "%dx%d%c", &request.width, &request.height, &rest) !=
           2 ||
       request.width < WindowLayout::kLeastWidth || request.height < WindowLayout::kLeastHeight ||
       request.width > kMostPixels || request.height > kMostPixels)) {
    return Refusal(Format("--size %s is no size, expected WIDTHxHEIGHT from %dx%d to %dx%d px",
                          arguments->size.c_str(),
                          WindowLayout::kLeastWidth,
                          WindowLayout::kLeastHeight,
                          kMostPixels,
                          kMostPixels));
  }
  if (!arguments->at.empty() && arguments->at != "end") {
    double at = 0.0;
    if (std::sscanf(arguments->at.c_str(), "%lf%c", &at, &rest) != 1 || !(at >= 0.0 && at < 1e9)) {
      return Refusal(Format("--at %s is no time, expected seconds from the log's start, or end",
                            arguments->at.c_str()));
    }
    request.at = at;
  }
  if (!arguments->vector.empty()) {
    const Eigen::Vector3d v(arguments->vector[0], arguments->vector[1], arguments->vector[2]);
    if (!v.allFinite() || v.norm() < 1e-9) {
      return Refusal("--vector has no direction, expected three numbers, not all 0");
    }
    arguments->options.vector = v.normalized();
  }
  arguments->cloud.voxel = 1e-3 * arguments->voxel_mm;
  if (arguments->log.empty() && arguments->config.empty()) {
    return Refusal("nothing to show, expected a log, or --config FILE of a running set-up");
  }
  if (!arguments->offscreen) return {};
  if (arguments->log.empty()) return Refusal("--offscreen draws logs, expected one");
  if (request.picture.empty() && request.video.empty()) {
    return Refusal("--offscreen has nothing to write, expected --output FILE.png or --video FILE");
  }
  if (!request.video.empty() && (request.width % 2 != 0 || request.height % 2 != 0)) {
    return Refusal(
        Format("--size %s has an odd side, which videos can't have", arguments->size.c_str()));
  }
  return {};
}

Result<std::unique_ptr<LogPlayer>> OpenLog(const Arguments& arguments) {
  Result<std::unique_ptr<LogPlayer>> player = LogPlayer::Open(arguments.log, arguments.cloud);
  if (!player) return player;
  const bool is_terminal = isatty(STDERR_FILENO) != 0;
  int shown = -1;
  Result<void> surveyed = (*player)->Survey([&](double share) {
    const int percent = static_cast<int>(100.0 * share);
    if (is_terminal && percent != shown) std::fprintf(stderr, "\rreading %3d %%", percent);
    shown = percent;
  });
  if (is_terminal) std::fprintf(stderr, "\r%16s\r", "");
  if (!surveyed) return surveyed.error();
  if (const std::string damage = (*player)->Damage(); !damage.empty()) {
    std::fprintf(stderr, "vantage-viewer: log %s: %s\n", arguments.log.c_str(), damage.c_str());
  }
  return player;
}

Result<void> ViewLive(const Arguments& arguments, const ViewerSetup& setup) {
  LiveBus::Options options = setup.bus;
  if (!arguments.lcm_url.empty()) options.url = arguments.lcm_url;
  options.name = Format("viewer-%d", getpid());
  options.version = VANTAGE_VERSION;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
  if (!bus) return bus.error();
  return ShowLive({arguments.request.width, arguments.request.height},
                  setup,
                  arguments.options,
                  arguments.cloud,
                  **bus);
}

/// @return the exit code.
Result<int> View(Arguments arguments) {
  if (Result<void> complete = Complete(&arguments); !complete) return complete.error();
  if (!arguments.offscreen) {
    if (Result<void> display = CheckDisplay(); !display) return display.error();
  }
  Result<ViewerSetup> setup = LoadViewerSetup(arguments.config, arguments.log);
  if (!setup) return setup.error();
  arguments.options.table_height = setup->table_height;
  if (arguments.log.empty()) {
    if (Result<void> viewed = ViewLive(arguments, *setup); !viewed) return viewed.error();
    return 0;
  }
  Result<std::unique_ptr<LogPlayer>> player = OpenLog(arguments);
  if (!player) return player.error();
  if (!setup->warning.empty()) {
    std::fprintf(stderr, "vantage-viewer: %s\n", setup->warning.c_str());
  }
  const OffscreenRequest& request = arguments.request;
  if (!arguments.offscreen) {
    ShowLog({request.width, request.height}, *setup, arguments.options, request.speed, **player);
    return 0;
  }
  const Interrupt interrupt("the frame in work");
  std::optional<VirtualDisplay> display;
  if (!CheckDisplay()) {
    Result<VirtualDisplay> started = VirtualDisplay::Start(request.width, request.height);
    if (!started) return started.error();
    display.emplace(std::move(started).value());
  }
  Result<void> drawn =
      DrawOffscreen(request, *setup, arguments.options, **player, interrupt.token());
  if (!drawn) return drawn.error();
  return interrupt.token().stop_requested() ? kInterrupted : 0;
}

void AddArguments(CLI::App* app, Arguments* arguments) {
  app->add_option("log", arguments->log, "log of a run; without one the running set-up is shown");
  app->add_option("--config,-c",
                  arguments->config,
                  "TOML file of the set-up; default: the one in the log's LOG_HEADER");
  app->add_option("--lcm-url", arguments->lcm_url, "of the running set-up; default: [bus]");
  CLI::Option* offscreen = app->add_flag("--offscreen",
                                         arguments->offscreen,
                                         "draw without a window; starts Xvfb where no X server is");
  app->add_option("--output,-o", arguments->request.picture, "PNG file to write")->needs(offscreen);
  app->add_option("--at", arguments->at, "s from the log's start, of --output; default: end")
      ->needs(offscreen);
  CLI::Option* video = app->add_option(
      "--video", arguments->request.video, "video of the whole log to write: .mp4, .webm or .gif");
  video->needs(offscreen);
  app->add_option("--fps", arguments->request.fps, "frames a second, of --video")
      ->needs(video)
      ->check(CLI::Range(0.1, 120.0))
      ->capture_default_str();
  app->add_option("--speed", arguments->request.speed, "seconds of the log that pass in one")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  app->add_option("--size", arguments->size, "of window, picture and video, px; default: 1600x900");
  app->add_option("--vector",
                  arguments->vector,
                  "which of the object's directions the spheres show; default: 1 1 1")
      ->expected(3);
  app->add_option("--object", arguments->options.object, "instance whose orientation is shown");
  app->add_option("--cloud-color",
                  arguments->options.cloud_color,
                  "depth, height or image; default: image, and height where there is none")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, CloudColor>{{"depth", CloudColor::kDepth},
                                                                    {"height", CloudColor::kHeight},
                                                                    {"image", CloudColor::kImage}}))
      ->option_text("NAME");
  app->add_option("--voxel-mm", arguments->voxel_mm, "of the cloud: one point in each cube")
      ->check(CLI::Range(0.5, 1000.0))
      ->capture_default_str();
  app->footer(KeyHelp());
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("Shows a running set-up, or a log of one, in three dimensions", "vantage-viewer");
  vantage::AddArguments(&app, &arguments);
  if (const std::optional<int> ended = vantage::ParseCommandLine(app, argc, argv)) return *ended;
  const vantage::Result<int> code = vantage::View(arguments);
  if (!code) {
    std::fprintf(stderr, "vantage-viewer: %s\n", code.error().message.c_str());
    return 2;
  }
  return *code;
}
