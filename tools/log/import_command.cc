#include "tools/log/import_command.h"

#include <cstdio>
#include <filesystem>

#include "common/format.h"
#include "tools/support/bop_folder.h"
#include "tools/support/view_folder.h"

namespace vantage {

namespace fs = std::filesystem;

ImportCommand::ImportCommand(CLI::App* app)
    : command_(app->add_subcommand("import", "make a log of a folder of recorded views")) {
  command_->add_option("folder", folder_, "view folder, or folder in BOP format")->required();
  command_->add_option("--output", log_, "the log to write")->required();
  command_->add_option("--camera", parameters_.camera, "<NAME> of the channels")->required();
  command_->add_option("--format", format_, "auto, views or bop")
      ->check(CLI::IsMember({"auto", "views", "bop"}));
  command_->add_option(
      "--config,-c", config_, "TOML file of the set-up for which it is, to go into LOG_HEADER");
  command_->add_option("--compression", compression_, "of depth, lossless: vdc, zlib or raw (vdc)")
      ->check(CLI::IsMember({"vdc", "zlib", "raw"}));
  command_->add_option("--depth-scale",
                       depth_scale_,
                       "mm for a value of 1; otherwise 1 for views, what the files say for bop");
  command_->add_option(
      "--view-interval", parameters_.view_interval, "s from one view to the next (1)");
  command_->add_option(
      "--start-utime", parameters_.start_utime, "us since the epoch at which the log starts");
  command_->add_option("--scene", scene_, "number of the scene of a BOP folder");
}

Result<int> ImportCommand::Run() const {
  LogImportParameters parameters = parameters_;
  if (compression_ != "vdc") {
    parameters.compression =
        compression_ == "zlib" ? DepthCompression::kZlib : DepthCompression::kNone;
  }
  if (Result<void> fits = parameters.Validate(); !fits) return fits.error();
  Result<LogSetup> setup = ReadLogSetup(config_);
  if (!setup) return setup.error();
  parameters.setup = std::move(setup).value();
  const Result<std::vector<RecordedView>> views = ListViews();
  if (!views) return views.error();
  const Result<LogImportSummary> summary = ImportViews(*views, parameters, log_);
  if (!summary) return summary.error();
  std::printf("wrote %s: %jd views of %d x %d px, %jd events\n",
              log_.c_str(),
              intmax_t{summary->num_views},
              summary->width,
              summary->height,
              intmax_t{summary->num_events});
  return 0;
}

Result<std::vector<RecordedView>> ImportCommand::ListViews() const {
  const fs::path folder = folder_;
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("no folder %s, expected recorded views", folder.c_str())};
  }
  std::string format = format_;
  if (format == "auto") {
    if (!IsBopFolder(folder) && !IsViewFolder(folder)) {
      return Error{ErrorCode::kNotFound,
                   Format("folder %s has no depth images, expected depth_N.png, "
                          "frame-N.depth.png or a BOP scene with scene_camera.json",
                          folder.c_str())};
    }
    format = IsBopFolder(folder) ? "bop" : "views";
  }
  if (depth_scale_ && !(*depth_scale_ > 0.0 && *depth_scale_ < 1e6)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("depth scale %g, expected a positive number of millimetres", *depth_scale_)};
  }
  if (format == "bop") return ListBopScene(folder, scene_, depth_scale_);
  if (scene_) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--scene %d for view folder %s, expected it only for a BOP folder",
                        *scene_,
                        folder.c_str())};
  }
  return ListViewFolder(folder, depth_scale_.value_or(1.0));
}

}  // namespace vantage
