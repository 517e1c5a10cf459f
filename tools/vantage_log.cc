// Makes LCM logs of recorded views, and tells what is in a log.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/format.h"
#include "common/result.h"
#include "nodes/command_line.h"
#include "tools/support/bop_folder.h"
#include "tools/support/log_import.h"
#include "tools/support/view_folder.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string folder;
  std::string log;
  std::string format = "auto";
  std::optional<double> depth_scale;
  std::optional<int> scene;
  LogImportParameters parameters;
};

Result<std::vector<RecordedView>> ListViews(const Arguments& arguments) {
  const fs::path folder = arguments.folder;
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("no folder %s, expected recorded views", folder.c_str())};
  }
  std::string format = arguments.format;
  if (format == "auto") {
    if (!IsBopFolder(folder) && !IsViewFolder(folder)) {
      return Error{ErrorCode::kNotFound,
                   Format("folder %s has no depth images, expected depth_N.png, "
                          "frame-N.depth.png or a BOP scene with scene_camera.json",
                          folder.c_str())};
    }
    format = IsBopFolder(folder) ? "bop" : "views";
  }
  if (arguments.depth_scale && !(*arguments.depth_scale > 0.0 && *arguments.depth_scale < 1e6)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("depth scale %g, expected a positive number of millimetres",
                        *arguments.depth_scale)};
  }
  if (format == "bop") return ListBopScene(folder, arguments.scene, arguments.depth_scale);
  if (arguments.scene) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--scene %d for view folder %s, expected it only for a BOP folder",
                        *arguments.scene,
                        folder.c_str())};
  }
  return ListViewFolder(folder, arguments.depth_scale.value_or(1.0));
}

Result<void> Import(const Arguments& arguments) {
  if (Result<void> fits = arguments.parameters.Validate(); !fits) return fits;
  const Result<std::vector<RecordedView>> views = ListViews(arguments);
  if (!views) return views.error();
  const Result<LogImportSummary> summary = ImportViews(*views, arguments.parameters, arguments.log);
  if (!summary) return summary.error();
  std::printf("wrote %s: %jd views of %d x %d px, %jd events\n",
              arguments.log.c_str(),
              intmax_t{summary->num_views},
              summary->width,
              summary->height,
              intmax_t{summary->num_events});
  return {};
}

// What is counted of one channel.
struct ChannelCount {
  std::string type;
  int64_t events = 0;
  int64_t bytes = 0;
  int64_t first_utime = 0;
  int64_t last_utime = 0;
};

std::string TypeName(const LogEvent& event) {
  constexpr size_t kFingerprintBytes = 8;
  if (event.data.size() < kFingerprintBytes) return "(too short)";
  const auto fingerprint = LoadBigEndian<int64_t>(event.data);
  const MessageSchema* schema = FindSchema(fingerprint);
  return schema != nullptr ? std::string(schema->name)
                           : Format("%016jx", static_cast<uintmax_t>(fingerprint));
}

void Count(const LogEvent& event, ChannelCount* count) {
  const std::string type = TypeName(event);
  if (count->events == 0) {
    count->type = type;
    count->first_utime = event.utime;
    count->last_utime = event.utime;
  } else if (count->type != type) {
    count->type = "(several)";
  }
  ++count->events;
  count->bytes += static_cast<int64_t>(event.data.size());
  count->first_utime = std::min(count->first_utime, event.utime);
  count->last_utime = std::max(count->last_utime, event.utime);
}

Result<void> Info(const Arguments& arguments) {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(arguments.log);
  if (!reader) return reader.error();
  std::map<std::string, ChannelCount> channels;
  ChannelCount all;
  int64_t out_of_order = 0;
  int64_t previous = 0;
  while (const std::optional<LogEvent> event = (*reader)->Next()) {
    if (all.events > 0 && event->utime < previous) ++out_of_order;
    previous = event->utime;
    Count(*event, &channels[event->channel]);
    Count(*event, &all);
  }
  const auto seconds = [](const ChannelCount& count) {
    return 1e-6 * static_cast<double>(count.last_utime - count.first_utime);
  };
  std::printf("%s: %jd events, %.1f MB, %.3f s from %.6f\n",
              arguments.log.c_str(),
              intmax_t{all.events},
              1e-6 * static_cast<double>(all.bytes),
              seconds(all),
              1e-6 * static_cast<double>(all.first_utime));
  std::printf("%-32s %-26s %9s %10s %12s\n", "channel", "type", "events", "rate Hz", "mean bytes");
  for (const auto& [channel, count] : channels) {
    const double span = seconds(count);
    const std::string rate =
        span > 0.0 ? Format("%.2f", static_cast<double>(count.events - 1) / span) : "-";
    std::printf("%-32s %-26s %9jd %10s %12jd\n",
                channel.c_str(),
                count.type.c_str(),
                intmax_t{count.events},
                rate.c_str(),
                intmax_t{count.bytes / count.events});
  }
  if (out_of_order > 0) {
    std::printf("out of order: %jd events are earlier than the one before\n",
                intmax_t{out_of_order});
  }
  const EventLogReader::Damage& damage = (*reader)->damage();
  std::printf("damage: %s\n", damage.any() ? damage.Describe().c_str() : "none");
  return {};
}

int Run(int argc, char** argv) {
  CLI::App app("Makes LCM logs of recorded views, and tells what is in a log.", "vantage-log");
  app.require_subcommand(1);
  Arguments arguments;

  CLI::App* import = app.add_subcommand("import", "make a log of a folder of recorded views");
  import->add_option("folder", arguments.folder, "view folder, or folder in BOP format")
      ->required();
  import->add_option("--output", arguments.log, "the log to write")->required();
  import->add_option("--camera", arguments.parameters.camera, "<NAME> of the channels")->required();
  import->add_option("--format", arguments.format, "auto, views or bop")
      ->check(CLI::IsMember({"auto", "views", "bop"}));
  import->add_option("--depth-scale",
                     arguments.depth_scale,
                     "mm for a value of 1; otherwise 1 for views, what the files say for bop");
  import->add_option(
      "--view-interval", arguments.parameters.view_interval, "s from one view to the next (1)");
  import->add_option("--start-utime",
                     arguments.parameters.start_utime,
                     "us since the epoch at which the log starts");
  import->add_option("--scene", arguments.scene, "number of the scene of a BOP folder");

  CLI::App* info = app.add_subcommand("info", "tell what is in a log");
  info->add_option("log", arguments.log, "the log")->required();

  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  const Result<void> done = *import ? Import(arguments) : Info(arguments);
  if (!done) {
    std::fprintf(stderr, "vantage-log: %s\n", done.error().message.c_str());
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
