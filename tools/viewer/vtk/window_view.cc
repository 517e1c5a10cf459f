#include "tools/viewer/vtk/window_view.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include "common/format.h"
#include "tools/viewer/viewer_keys.h"
#include "tools/viewer/vtk/viewer_window.h"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kRedrawLive = std::chrono::milliseconds(200);
constexpr double kLongestStep = 2.0;  // s that playing goes on by at a time
constexpr auto kLongestIntake = std::chrono::milliseconds(30);

// What a log and a bus have in common on the screen.
class WindowView {
 public:
  WindowView(const WindowSize& size, const ViewerSetup& setup, const ViewerOptions& options)
      : setup_(setup), options_(options), window_(size.width, size.height, false) {}

  void Redraw(const ViewerState& state, const ShownTime& time, const ShownPlayback& playback) {
    const ViewerScene scene = BuildScene(state, setup_.models, options_);
    const ShownObject* chosen = ChosenObject(state, options_);
    const int chosen_instance = chosen == nullptr ? -1 : chosen->instance;
    if (chosen_instance != closeup_of_) window_.LookAtCloseup(scene.closeup);
    closeup_of_ = chosen_instance;
    width_ = window_.width();
    height_ = window_.height();
    window_.Show(
        scene,
        drawer_.Draw(state, scene, options_, time, playback, window_.width(), window_.height()));
  }

  // The usual view.
  void Fit(const ViewerState& state) {
    const ViewerScene scene = BuildScene(state, setup_.models, options_);
    window_.LookAtOverview(scene.overview);
    window_.LookAtCloseup(scene.closeup);
  }

  // True when the picture has to be drawn anew.
  bool OnKey(const std::string& key, const ViewerState& state) {
    if (key == "q" || key == "Escape") window_.Close();
    if (key == "s") SaveScreenshot();
    if (key == "f") Fit(state);
    return ChangeOptions(key, state, &options_) || key == "f";
  }

  [[nodiscard]] bool WasResized() const {
    return window_.width() != width_ || window_.height() != height_;
  }
  [[nodiscard]] ViewerWindow& window() { return window_; }

 private:
  void SaveScreenshot() {
    std::filesystem::path file;
    int number = 1;
    do {
      file = Format("vantage-viewer-%03d.png", number++);
    } while (std::filesystem::exists(file));
    const Result<void> written = WritePng(file, window_.Grab());
    std::fprintf(
        stderr,
        "vantage-viewer: %s\n",
        written ? Format("screenshot %s", file.c_str()).c_str() : written.error().message.c_str());
  }

  const ViewerSetup& setup_;
  ViewerOptions options_;
  ViewerWindow window_;
  PageDrawer drawer_;
  int closeup_of_ = -1;
  int width_ = 0;
  int height_ = 0;
};

// Goes through a log as the user wants.
class LogView {
 public:
  LogView(WindowView& view, double speed, LogPlayer& player)
      : view_(view), player_(player), speed_(speed), utime_(player.start_utime()) {}

  void Run() {
    player_.GoTo(player_.end_utime());
    view_.Fit(player_.state());  // Of the start there is little to see.
    GoTo(player_.start_utime());
    view_.window().Run({[this](const std::string& key) { OnKey(key); },
                        [this] { OnTick(); },
                        [this](double place) { OnSlider(place); }},
                       true);
  }

 private:
  void GoTo(int64_t utime) {
    utime_ = std::clamp(utime, player_.start_utime(), player_.end_utime());
    player_.GoTo(utime_);
    Redraw();
  }
  void Redraw() {
    const auto span = static_cast<double>(player_.end_utime() - player_.start_utime());
    view_.window().SetSlider(span > 0.0 ? static_cast<double>(utime_ - player_.start_utime()) / span
                                        : 1.0);
    view_.Redraw(player_.state(),
                 {player_.start_utime(), player_.end_utime(), utime_},
                 {is_playing_, speed_});
  }
  void OnTick() {
    const Clock::time_point now = Clock::now();
    if (is_playing_) {
      // As much time again for the user's keys, however slow drawing is.
      if (now < next_frame_) return;
      if (utime_ >= player_.end_utime()) is_playing_ = false;
      const double passed = std::chrono::duration<double>(now - last_frame_).count();
      last_frame_ = now;
      GoTo(utime_ + static_cast<int64_t>(1e6 * speed_ * std::min(passed, kLongestStep)));
      next_frame_ = Clock::now() + (Clock::now() - now);
    } else if (view_.WasResized()) {
      Redraw();
    }
  }
  void OnKey(const std::string& key) {
    if (key == "space") {
      is_playing_ = !is_playing_;
      last_frame_ = Clock::now();
      if (is_playing_ && utime_ >= player_.end_utime()) utime_ = player_.start_utime();
      Redraw();
    } else if (key == "plus" || key == "equal" || key == "KP_Add") {
      speed_ = std::min(64.0, 2.0 * speed_);
      Redraw();
    } else if (key == "minus" || key == "KP_Subtract") {
      speed_ = std::max(1.0 / 16.0, 0.5 * speed_);
      Redraw();
    } else if (const std::optional<int64_t> utime = KeyTime(key, player_, utime_)) {
      is_playing_ = false;
      GoTo(*utime);
    } else if (view_.OnKey(key, player_.state())) {
      Redraw();
    }
  }
  void OnSlider(double place) {
    is_playing_ = false;
    const auto span = static_cast<double>(player_.end_utime() - player_.start_utime());
    GoTo(player_.start_utime() + static_cast<int64_t>(std::llround(place * span)));
  }

  WindowView& view_;
  LogPlayer& player_;
  double speed_;
  int64_t utime_;
  bool is_playing_ = false;
  Clock::time_point last_frame_ = Clock::now();
  Clock::time_point next_frame_ = Clock::now();
};

}  // namespace

void ShowLog(const WindowSize& size,
             const ViewerSetup& setup,
             const ViewerOptions& options,
             double speed,
             LogPlayer& player) {
  WindowView view(size, setup, options);
  LogView(view, speed, player).Run();
}

Result<void> ShowLive(const WindowSize& size,
                      const ViewerSetup& setup,
                      const ViewerOptions& options,
                      const SceneCloud::Parameters& cloud,
                      LiveBus& bus) {
  ViewerState state(cloud);
  bool is_new = true;
  bool is_fitted = false;  // With what the planner looks at.
  Result<void> tapped =
      bus.Tap(".*", {}, [&](const Envelope& envelope, std::span<const std::byte> bytes) {
        state.Apply(envelope.channel, envelope.receive_utime, bytes);
        is_new = true;
      });
  if (!tapped) return tapped;
  WindowView view(size, setup, options);
  const int64_t start_utime = bus.NowUtime();
  Clock::time_point drawn{};
  const auto redraw = [&] {
    view.Redraw(state, {start_utime, 0, bus.NowUtime()}, {});
    is_new = false;
    drawn = Clock::now();
  };
  view.Fit(state);
  redraw();
  view.window().Run({[&](const std::string& key) {
                       if (view.OnKey(key, state)) redraw();
                     },
                     [&] {
                       const Clock::time_point start = Clock::now();
                       while (Clock::now() - start < kLongestIntake &&
                              bus.Dispatch(std::chrono::milliseconds(0))) {
                       }
                       if (!is_fitted && !state.plan().candidates.empty()) {
                         view.Fit(state);
                         is_fitted = true;
                       }
                       if ((is_new && Clock::now() - drawn > kRedrawLive) || view.WasResized())
                         redraw();
                     },
                     {}},
                    false);
  return {};
}

}  // namespace vantage
