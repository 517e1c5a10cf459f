#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

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

/// Where in a run the picture is, for the status line.
struct ShownTime {
  int64_t start_utime = 0;  ///< us since the epoch
  int64_t end_utime = 0;    ///< us since the epoch; 0: live
  int64_t utime = 0;        ///< us since the epoch
};

/// How a log is being played.
struct ShownPlayback {
  bool is_playing = false;
  double speed = 1.0;  ///< seconds of the log that pass in one
};

/// Draws everything but the scene itself. Keeps the spheres for as long as they are the same: they
/// take the longest.
class PageDrawer {
 public:
  Page Draw(const ViewerState& state,
            const ViewerScene& scene,
            const ViewerOptions& options,
            const ShownTime& time,
            const ShownPlayback& playback,
            int width,
            int height);

 private:
  // What the panel of the orientation is made from.
  struct Source {
    std::shared_ptr<const orientation_histogram_t> histogram;
    int64_t objects_utime = -1;
    int32_t instance = -1;
    Eigen::Vector3d vector = Eigen::Vector3d::Zero();
    PixelBox box;
    bool operator==(const Source&) const = default;
  };
  Source source_;
  Page orientation_;  // As large as its box.
};

}  // namespace vantage
