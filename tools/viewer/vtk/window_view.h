#pragma once

#include "bus/live_bus.h"
#include "common/result.h"
#include "tools/viewer/log_player.h"
#include "tools/viewer/viewer_options.h"
#include "tools/viewer/viewer_setup.h"

namespace vantage {

/// Size of a window, px.
struct WindowSize {
  int width = 1600;
  int height = 900;
};

/// Shows a log, from its start, until the user closes the window. A player that was surveyed.
/// @param speed seconds of the log that pass in one
void ShowLog(const WindowSize& size,
             const ViewerSetup& setup,
             const ViewerOptions& options,
             double speed,
             LogPlayer& player);

/// Shows what comes over the bus until the user closes the window. Errors: as LiveBus::Tap().
Result<void> ShowLive(const WindowSize& size,
                      const ViewerSetup& setup,
                      const ViewerOptions& options,
                      const SceneCloud::Parameters& cloud,
                      LiveBus& bus);

}  // namespace vantage
