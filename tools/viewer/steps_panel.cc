#include "tools/viewer/steps_panel.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "tools/viewer/viewer_scene.h"

namespace vantage {
namespace {

constexpr int kHeadHeight = 24;    // px
constexpr int kNameWidth = 118;    // px
constexpr int kColumnWidth = 116;  // px
constexpr int kLeastRow = 34;      // px
constexpr int kMostRow = 56;       // px

// The peaks' weights as parts of one bar, the heaviest at the bottom.
void DrawWeights(const StepEntry& entry, Rgb color, const PixelBox& box, RgbImage& image) {
  FillBox(box, {236, 237, 241}, image);
  double below = 0.0;
  for (size_t i = 0; i < entry.peak_weights.size(); ++i) {
    const double above = std::min(1.0, below + entry.peak_weights[i]);
    const int top = box.bottom() - static_cast<int>(std::lround(above * box.height));
    const int bottom = box.bottom() - static_cast<int>(std::lround(below * box.height));
    const double pale = std::min(0.8, 0.3 * static_cast<double>(i));
    FillBox({box.x, top, box.width, bottom - top}, Mix(color, {255, 255, 255}, pale), image);
    if (i > 0) FillBox({box.x, bottom - 1, box.width, 1}, kPaper, image);
    below = above;
  }
}

void DrawEntry(const StepEntry& entry, Rgb color, const PixelBox& box, Page* page) {
  constexpr int kBarWidth = 14;  // px
  const PixelBox bar{box.x, box.y + 4, kBarWidth, box.height - 8};
  DrawWeights(entry, color, bar, page->image);
  const double x = bar.right() + 6.0;
  const double middle = box.y + 0.5 * box.height;
  if (!entry.detection) {
    page->texts.push_back({x, middle, "not seen", 11, kFaintInk});
    return;
  }
  page->texts.push_back({x,
                         middle - 7.0,
                         Format("%.1f deg %.1f mm", entry.angle / kDegree, 1e3 * entry.distance),
                         11,
                         kInk});
  page->texts.push_back({x,
                         middle + 7.0,
                         Format("p%zu %.0f %%  s %.2f",
                                entry.nearest_peak + 1,
                                100.0 * entry.peak_weights[entry.nearest_peak],
                                entry.score),
                         11,
                         kFaintInk});
}

std::string StateText(const ShownObject& object) {
  std::string text = object.state == object_estimate_v3_t::CONFIRMED ? "confirmed"
                     : object.state == object_estimate_v3_t::LOST    ? "lost"
                                                                     : "tentative";
  if (object.converged) text = object.refined ? "settled, refined" : "settled";
  return text;
}

}  // namespace

void DrawStepsPanel(const ViewerState& state,
                    const ViewerOptions& options,
                    const PixelBox& box,
                    Page* page) {
  page->texts.push_back({box.x + 10.0,
                         box.y + 0.5 * kHeadHeight,
                         "Detections and peaks by view",
                         14,
                         kInk,
                         TextSide::kLeft,
                         true});
  page->texts.push_back({box.x + 250.0,
                         box.y + 0.5 * kHeadHeight,
                         "bar: weights of the peaks; deg, mm: this view's detection from the "
                         "estimate, s its score; p: nearest peak, its weight",
                         12,
                         kFaintInk});
  const auto& objects = state.objects().objects;
  const auto& steps = state.steps();
  const int first_y = box.y + kHeadHeight + 18;
  const int room = std::max(1, (box.bottom() - first_y) / kLeastRow);
  // The chosen object is always among those shown.
  const ShownObject* chosen = ChosenObject(state, options);
  const auto chosen_index = static_cast<int>(chosen == nullptr ? 0 : chosen - objects.data());
  const int num_rows = std::min(room, static_cast<int>(objects.size()));
  const int first_row = std::clamp(chosen_index - num_rows + 1, 0, std::max(0, chosen_index));
  const int num_columns = std::min(std::max(1, (box.width - kNameWidth - 10) / kColumnWidth),
                                   static_cast<int>(steps.size()));
  const size_t first_step = steps.size() - static_cast<size_t>(num_columns);
  const auto column_x = [&](int column) { return box.x + 10 + kNameWidth + column * kColumnWidth; };
  for (int column = 0; column < num_columns; ++column) {
    page->texts.push_back(
        {static_cast<double>(column_x(column)),
         box.y + kHeadHeight + 8.0,
         Format("view %d", steps[first_step + static_cast<size_t>(column)].viewpoint + 1),
         12,
         kFaintInk});
  }
  if (num_rows == 0) return;
  const int row_height = std::min(kMostRow, (box.bottom() - first_y) / num_rows);
  for (int row = 0; row < num_rows; ++row) {
    const ShownObject& object = objects[static_cast<size_t>(first_row + row)];
    const Rgb color = ColorOfInstance(object.instance);
    const int y = first_y + row * row_height;
    if (&object == chosen) FillBox({box.x + 3, y + 4, 3, row_height - 8}, color, page->image);
    page->texts.push_back(
        {box.x + 10.0,
         y + 0.5 * row_height - 7.0,
         PrintableText(Format("%d %s", object.instance, object.model_id.c_str()), 15),
         13,
         color,
         TextSide::kLeft,
         true});
    page->texts.push_back(
        {box.x + 10.0, y + 0.5 * row_height + 8.0, StateText(object), 11, kFaintInk});
    for (int column = 0; column < num_columns; ++column) {
      const ShownStep& step = steps[first_step + static_cast<size_t>(column)];
      const auto entry = step.objects.find(object.instance);
      if (entry == step.objects.end()) continue;
      DrawEntry(entry->second, color, {column_x(column), y, kColumnWidth, row_height}, page);
    }
  }
}

}  // namespace vantage
