#include "tools/viewer/vtk/offscreen_view.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "tools/viewer/video_writer.h"
#include "tools/viewer/vtk/viewer_window.h"

namespace vantage {
namespace {

constexpr double kMostFrames = 100'000;

class Offscreen {
 public:
  Offscreen(const OffscreenRequest& request,
            const ViewerSetup& setup,
            const ViewerOptions& options,
            LogPlayer& player)
      : request_(request),
        setup_(setup),
        options_(options),
        player_(player),
        window_(request.width, request.height, true) {
    // From the end on the whole way: the same view for all frames.
    player_.GoTo(player_.end_utime());
    window_.LookAtOverview(BuildScene(player_.state(), setup_.models, options_).overview);
  }

  RgbImage FrameAt(int64_t utime) {
    player_.GoTo(utime);
    const ViewerScene scene = BuildScene(player_.state(), setup_.models, options_);
    window_.LookAtCloseup(scene.closeup);
    window_.Show(scene,
                 drawer_.Draw(player_.state(),
                              scene,
                              options_,
                              {player_.start_utime(), player_.end_utime(), utime},
                              {},
                              request_.width,
                              request_.height));
    return window_.Grab();
  }

  Result<void> DrawVideo(const std::stop_token& stop) {
    Result<std::unique_ptr<VideoWriter>> video =
        VideoWriter::Create(request_.video, request_.width, request_.height, request_.fps);
    if (!video) return video.error();
    const double step = 1e6 * request_.speed / request_.fps;  // us
    const auto span = static_cast<double>(player_.end_utime() - player_.start_utime());
    const double num_frames = std::floor(span / step) + 1.0;
    if (num_frames > kMostFrames) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("video of %.0f frames, expected at most %.0f: ask for a higher --speed",
                          num_frames,
                          kMostFrames)};
    }
    for (int64_t i = 0; i < static_cast<int64_t>(num_frames); ++i) {
      if (stop.stop_requested()) return {};
      const int64_t utime =
          player_.start_utime() + static_cast<int64_t>(std::llround(step * static_cast<double>(i)));
      if (Result<void> written = (*video)->Write(FrameAt(utime)); !written) return written;
    }
    return (*video)->Close();
  }

  Result<void> DrawPicture() {
    int64_t utime = player_.end_utime();
    if (request_.at) {
      const double length = 1e-6 * static_cast<double>(player_.end_utime() - player_.start_utime());
      if (*request_.at > length) {
        return Error{ErrorCode::kInvalidArgument,
                     Format("--at %g is after the log's end at %.2f s", *request_.at, length)};
      }
      utime = player_.start_utime() + static_cast<int64_t>(std::llround(1e6 * *request_.at));
    }
    return WritePng(request_.picture, FrameAt(utime));
  }

 private:
  const OffscreenRequest& request_;
  const ViewerSetup& setup_;
  ViewerOptions options_;
  LogPlayer& player_;
  ViewerWindow window_;
  PageDrawer drawer_;
};

}  // namespace

Result<void> DrawOffscreen(const OffscreenRequest& request,
                           const ViewerSetup& setup,
                           const ViewerOptions& options,
                           LogPlayer& player,
                           const std::stop_token& stop) {
  Offscreen offscreen(request, setup, options, player);
  if (!request.picture.empty()) {
    if (Result<void> drawn = offscreen.DrawPicture(); !drawn) return drawn;
  }
  return request.video.empty() ? Result<void>() : offscreen.DrawVideo(stop);
}

}  // namespace vantage
