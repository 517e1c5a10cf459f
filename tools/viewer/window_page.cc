#include "tools/viewer/window_page.h"

#include <algorithm>
#include <string>
#include <utility>

#include "common/format.h"
#include "tools/support/rgb_canvas.h"
#include "tools/viewer/orientation_panel.h"
#include "tools/viewer/steps_panel.h"

namespace vantage {
namespace {

std::string TimeText(const ShownTime& time, const ShownPlayback& playback) {
  const double now = 1e-6 * static_cast<double>(time.utime - time.start_utime);
  if (time.end_utime == 0) return Format("live, %.0f s", now);
  std::string text = Format(
      "%.2f s of %.2f s", now, 1e-6 * static_cast<double>(time.end_utime - time.start_utime));
  if (playback.is_playing) text += Format(", playing at %g times", playback.speed);
  return text;
}

std::string StatusText(const ViewerState& state,
                       const ShownTime& time,
                       const ShownPlayback& playback) {
  std::string text = TimeText(time, playback);
  if (state.num_used() == 0) text += "   no message yet";
  const ShownObjects& objects = state.objects();
  text += Format("   view %d", objects.num_viewpoints);
  const auto confirmed =
      std::count_if(objects.objects.begin(), objects.objects.end(), [](const ShownObject& object) {
        return object.state == object_estimate_v3_t::CONFIRMED;
      });
  text += Format("   %zu objects, %td confirmed", objects.objects.size(), confirmed);
  if (objects.finished) text += ", finished";
  for (const auto& [name, camera] : state.cameras()) {
    if (!camera.state.empty()) text += "   " + name + " " + camera.state;
  }
  if (!state.arm_state().empty()) text += "   arm " + state.arm_state();
  for (const auto& [name, process] : state.processes()) text += "   " + name + ": " + process;
  return text;
}

void DrawStatus(const ViewerState& state,
                const std::string& text,
                const PixelBox& box,
                Page* page) {
  FillBox(box, kInk, page->image);
  const double middle = box.y + 0.5 * box.height;
  constexpr double kLetter = 0.55 * 14;
  const auto room = static_cast<size_t>((box.width - 260) / kLetter);
  page->texts.push_back({box.x + 10.0, middle, PrintableText(text, room), 14, kPaper});
  page->texts.push_back(
      {box.right() - 10.0,
       middle,
       Format("lost %jd   refused %jd", intmax_t{state.num_lost()}, intmax_t{state.num_refused()}),
       14,
       state.num_lost() + state.num_refused() > 0 ? Rgb{255, 170, 120} : kRule,
       TextSide::kRight});
}

void DrawLegend(const ViewerState& state,
                const ViewerScene& scene,
                const ViewerOptions& options,
                const PixelBox& box,
                Page* page) {
  const double upper = box.y + 13.0;
  const double lower = box.y + 31.0;
  const auto word = [&](double x, double y, const std::string& text, Rgb color) {
    page->texts.push_back({x, y, text, 12, color});
    return x + TextWidth(page->texts.back()) + 16.0;
  };
  double x = box.x + 10.0;
  if (scene.cloud_scale) {
    const char* what = scene.cloud_by_depth ? "cloud by depth" : "cloud by height";
    x = word(x, upper, what, kInk) - 6.0;
    x = DrawScale(x,
                  upper,
                  Format("%.2f", scene.cloud_scale->low),
                  Format("%.2f m", scene.cloud_scale->high),
                  &DepthColor,
                  page) +
        26.0;
  }
  if (scene.gain_scale) {
    x = word(x, upper, "candidate views by gain", kInk) - 6.0;
    x = DrawScale(x,
                  upper,
                  Format("%.3g", scene.gain_scale->low),
                  Format("%.3g", scene.gain_scale->high),
                  &GainColor,
                  page) +
        20.0;
    x = word(x, upper, "out of reach", {150, 152, 160});
    x = word(x, upper, "next view", kChosenColor);
  }
  x = box.x + 10.0;
  if (options.show_uncertainty) {
    x = word(
        x,
        lower,
        Format("ellipsoid: position, %.0f sigma   cones: axes, %.0f sigma   pale models: other "
               "peaks   boxes: detections of the last view",
               options.ellipsoid_sigmas,
               options.cone_sigmas),
        kFaintInk);
  }
  if (!state.plan().reason.empty()) {
    const auto room = static_cast<size_t>(std::max(20.0, box.width / (0.55 * 12)));
    word(box.x + 10.0,
         box.y + 49.0,
         PrintableText("next view: " + state.plan().reason, room),
         kChosenColor);
  }
}

// Texts from `first` on end within the box.
void CutTexts(size_t first, const PixelBox& box, Page* page) {
  for (size_t i = first; i < page->texts.size(); ++i) {
    PageText& text = page->texts[i];
    if (text.side != TextSide::kLeft || text.x + TextWidth(text) <= box.right()) continue;
    const double letter = TextWidth(text) / static_cast<double>(text.text.size());
    const double room = (box.right() - text.x) / letter;
    text.text = room < 5.0 ? "" : PrintableText(text.text, static_cast<size_t>(room));
  }
}

}  // namespace

WindowLayout LayOut(int width, int height) {
  constexpr int kStatus = 28;  // px
  constexpr int kLegend = 60;  // px
  const int side = std::clamp(36 * width / 100, 340, 720);
  const int steps = std::clamp(22 * height / 100, 130, 240);
  WindowLayout layout;
  layout.status = {0, 0, width, kStatus};
  layout.orientation = {width - side, kStatus + 6, side, height - kStatus - 6};
  const int left = width - side - 1;
  layout.scene = {0, kStatus, left, height - kStatus - kLegend - steps};
  const int inset = std::min(38 * layout.scene.height / 100, left / 3);
  layout.closeup = {layout.scene.right() - inset - 8, layout.scene.y + 8, inset, inset};
  layout.legend = {0, layout.scene.bottom(), left, kLegend};
  layout.steps = {0, layout.legend.bottom(), left, steps};
  return layout;
}

Page PageDrawer::Draw(const ViewerState& state,
                      const ViewerScene& scene,
                      const ViewerOptions& options,
                      const ShownTime& time,
                      const ShownPlayback& playback,
                      int width,
                      int height) {
  const WindowLayout layout = LayOut(width, height);
  Page page;
  page.image = FilledImage(width, height, kPaper);
  FillBox(layout.scene, kSceneBackground, page.image);
  FillBox({layout.scene.right(), layout.scene.y, 1, height}, kRule, page.image);
  const PixelBox& closeup = layout.closeup;
  FillBox(
      {closeup.x - 1, closeup.y - 1, closeup.width + 2, closeup.height + 2}, kFaintInk, page.image);
  FillBox({0, layout.steps.y, layout.steps.width, 1}, kRule, page.image);
  DrawStatus(state, StatusText(state, time, playback), layout.status, &page);
  const size_t first = page.texts.size();
  DrawLegend(state, scene, options, layout.legend, &page);
  DrawStepsPanel(state, options, layout.steps, &page);
  CutTexts(first, layout.legend, &page);

  const PixelBox& box = layout.orientation;
  const ShownObject* object = ChosenObject(state, options);
  Source source;
  source.objects_utime = state.objects().utime;
  source.vector = options.vector;
  source.box = box;
  if (object != nullptr) {
    source.instance = object->instance;
    source.histogram = state.histogram(object->instance);
  }
  if (!(source == source_)) {
    orientation_.image = FilledImage(box.width, box.height, kPaper);
    orientation_.texts.clear();
    const PixelBox whole{0, 0, box.width, box.height};
    DrawOrientationPanel(state, options, whole, &orientation_);
    CutTexts(0, whole, &orientation_);
    source_ = source;
  }
  Paste(orientation_.image, box.x, box.y, page.image);
  for (PageText text : orientation_.texts) {
    text.x += box.x;
    text.y += box.y;
    page.texts.push_back(std::move(text));
  }
  return page;
}

}  // namespace vantage
