#include "tools/replay/replay_compare.h"

#include <cctype>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "common/format.h"
#include "tools/support/comparison_arguments.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// What a rerun publishes and a live run publishes too. ARM_STATUS and PROCESS_STATUS are of
// processes that are not rerun.
constexpr const char* kFusionChannels = "|OBJECTS|ORIENTATION_HISTOGRAM|NEXT_VIEW";
constexpr const char* kExtrinsicsChannels =
    "|CAMERA_.*_TO_WORLD|NEXT_HAND_POSE|HANDEYE_RESULT|HANDEYE_CHECK";

// A regular expression for them.
std::string ComparedChannels(const ReplayOptions& options) {
  std::string channels = "DETECTIONS_.*";
  if (options.as_received) {  // Those of other estimators are taken as they were recorded.
    std::string names;
    for (const std::string& name : options.estimators) {
      names += names.empty() ? "" : "|";
      for (const char c : name) names += static_cast<char>(std::toupper(c));
    }
    channels = "DETECTIONS_(" + names + ")";
  }
  channels += kFusionChannels;
  if (options.with_extrinsics) channels += kExtrinsicsChannels;
  return channels;
}

}  // namespace

void AddReplayCompareArguments(CLI::App* app, ReplayCompareOptions* options) {
  constexpr const char* kGroup = "Comparing";
  CLI::Option* recorded = app->add_flag("--compare",
                                        options->with_recorded,
                                        "compare with what the log holds; exits 1 where it differs")
                              ->group(kGroup);
  CLI::Option* other =
      app->add_option("--compare-with", options->other, "the same with what another log holds")
          ->group(kGroup)
          ->excludes(recorded);
  for (const char* part : {"--from", "--to"}) {
    // What a part of a log gives is nothing to compare: fusion starts anew there.
    recorded->excludes(app->get_option(part));
    other->excludes(app->get_option(part));
  }
  AddToleranceArguments(app, &options->tolerance);
}

Result<RecomputedLog> RecomputedLog::Create(const std::string& output) {
  RecomputedLog log;
  log.file_ = output;
  if (!output.empty()) return log;
  std::error_code error;
  std::string folder = (fs::temp_directory_path(error) / "vantage-replay.XXXXXX").string();
  if (error || ::mkdtemp(folder.data()) == nullptr) {
    return Error{
        ErrorCode::kIo,
        Format("temporary folder %s can't be made; --output FILE needs none", folder.c_str())};
  }
  log.folder_ = folder;
  log.file_ = log.folder_ / "recomputed.lcm";
  return log;
}

RecomputedLog::RecomputedLog(RecomputedLog&& other) noexcept
    : file_(std::move(other.file_)), folder_(std::exchange(other.folder_, {})) {}

RecomputedLog::~RecomputedLog() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

Result<LogComparison> CompareRerun(const ReplayOptions& options,
                                   const ReplayCompareOptions& compare,
                                   const fs::path& recomputed) {
  const std::string channels = ComparedChannels(options);
  const std::string& other = compare.other.empty() ? options.log : compare.other;
  Result<LogComparison> comparison = CompareLogs(other, recomputed, channels, compare.tolerance);
  if (!comparison) return comparison.error();
  for (const auto& [name, channel] : comparison->channels) {
    if (channel.count[0] > 0) return comparison;
  }
  return Error{ErrorCode::kNotFound,
               Format("log %s holds nothing of what a rerun makes, expected %s to compare with",
                      other.c_str(),
                      channels.c_str())};
}

}  // namespace vantage
