#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "common/result.h"
#include "tools/viewer/log_player.h"
#include "tools/viewer/viewer_options.h"
#include "tools/viewer/viewer_setup.h"

namespace vantage {

/// What to draw of a log without a screen.
struct OffscreenRequest {
  int width = 1600;          ///< px
  int height = 900;          ///< px
  std::optional<double> at;  ///< s from the log's start, of the picture; its end without
  std::string picture;       ///< PNG file; empty: none
  std::string video;         ///< file; empty: none
  double fps = 10.0;         ///< Hz, of the video
  double speed = 1.0;        ///< seconds of the log that pass in one of the video
};

/// Draws it. A player that was surveyed. A stop leaves no video behind. Errors: `at` is after the
/// log's end; the system refuses; as VideoWriter.
Result<void> DrawOffscreen(const OffscreenRequest& request,
                           const ViewerSetup& setup,
                           const ViewerOptions& options,
                           LogPlayer& player,
                           const std::stop_token& stop);

}  // namespace vantage
