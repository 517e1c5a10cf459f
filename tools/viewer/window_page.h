#pragma once

#include <cstdint>

#include "tools/viewer/page.h"
#include "tools/viewer/viewer_options.h"
#include "tools/viewer/viewer_scene.h"
#include "tools/viewer/viewer_state.h"

namespace vantage {

/// Where the parts of a window lie.
struct WindowLayout {
  static constexpr int kLeastWidth = 960;   ///< px
  static constexpr int kLeastHeight = 600;  ///< px

  PixelBox status;       ///< a line of text on top
  PixelBox scene;        ///< three dimensions, wide
  PixelBox closeup;      ///< three dimensions, the chosen object; inside of `scene`
  PixelBox legend;       ///< what the colors of the scene mean
  PixelBox steps;        ///< detections and peaks by view
  PixelBox orientation;  ///< spheres and circles
};

WindowLayout LayOut(int width, int height);

/// When the run began and ends, for the status line.
struct ShownTime {
  int64_t start_utime = 0;  ///< us since the epoch
  int64_t end_utime = 0;    ///< us since the epoch; 0: live
};

/// Everything but the scene itself.
Page DrawPage(const ViewerState& state,
              const ViewerScene& scene,
              const ViewerOptions& options,
              const ShownTime& time,
              int width,
              int height);

}  // namespace vantage
