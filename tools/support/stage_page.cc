#include "tools/support/stage_page.h"

#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "tools/support/gnuplot.h"
#include "tools/support/rgb_canvas.h"

namespace vantage {
namespace {

using Layout = StageLayout;

constexpr int kTextLine = 19;      // px
constexpr int kSwatch = 11;        // px
constexpr double kLetter = 6.4;    // px, mean width in a legend
constexpr double kBetween = 18.0;  // px, between two entries
constexpr Rgb kWords = {70, 72, 80};

void Paste(const RgbImage& from, int left, int top, RgbImage* to) {
  for (int v = 0; v < from.height; ++v) {
    for (int u = 0; u < from.width; ++u) SetPixel(*to, left + u, top + v, PixelAt(from, u, v));
  }
}

// gnuplot's text: in single quotes, which double.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

std::string Text(double u, double v, const std::string& text, Rgb color, const char* style) {
  return Format("set label %s at %.1f,%.1f front textcolor rgb '%s' %s\n",
                Quoted(text).c_str(),
                u,
                v,
                HexColor(color).c_str(),
                style);
}

// Draws swatches on the page and returns their words.
std::string Legend(const StagePanel& panel, int left, int top, RgbImage* page) {
  std::string script;
  double u = left;
  double v = top + 14.0;
  for (const StagePanel::Note& note : panel.legend) {
    const double words = kLetter * static_cast<double>(note.text.size());
    const double whole = words + (note.color ? kSwatch + 5.0 : 0.0);
    if (u > left && u + whole > left + Layout::kPanelWidth) {
      u = left;
      v += kTextLine;
    }
    if (note.color) {
      for (int dv = 0; dv < kSwatch; ++dv) {
        for (int du = 0; du < kSwatch; ++du) {
          SetPixel(
              *page, static_cast<int>(u) + du, static_cast<int>(v) - kSwatch / 2 + dv, *note.color);
        }
      }
      u += kSwatch + 5.0;
    }
    script += Text(u, v, note.text, kWords, "left font ',9'");
    u += words + kBetween;
  }
  return script;
}

// Words with a white rim, to be read on any color.
std::string RimmedText(double u, double v, const StagePanel::Label& label) {
  constexpr Rgb kRim = {255, 255, 255};
  std::string script;
  for (const auto& [du, dv] : {std::pair{-1.2, 0.0}, {1.2, 0.0}, {0.0, -1.2}, {0.0, 1.2}}) {
    script += Text(u + du, v + dv, label.text, kRim, "center font ':Bold,11'");
  }
  return script + Text(u, v, label.text, label.color, "center font ':Bold,11'");
}

}  // namespace

Result<std::string> RenderStagePage(std::span<const StagePanel> panels) {
  const int width = Layout::Width();
  const int height = Layout::Height(static_cast<int>(panels.size()));
  RgbImage page = FilledImage(width, height, {255, 255, 255});
  std::string words;
  int number = 0;
  for (const StagePanel& panel : panels) {
    VANTAGE_CHECK(
        panel.image.width == Layout::kPanelWidth && panel.image.height == Layout::kPanelHeight,
        "a picture of the layout's size");
    const int left = Layout::Left(number);
    const int top = Layout::Top(number);
    Paste(panel.image, left, top, &page);
    words += Text(left,
                  top - 14.0,
                  Format("%d  %s", number + 1, panel.title.c_str()),
                  {20, 20, 24},
                  "left font ':Bold,12'");
    words += Legend(panel, left, top + Layout::kPanelHeight, &page);
    for (const StagePanel::Label& label : panel.labels) {
      words += RimmedText(left + label.u, top + label.v, label);
    }
    ++number;
  }
  std::string script = Format(
      "set terminal pngcairo size %d,%d font 'sans,11'\n"
      "set termoption noenhanced\n"
      "unset border\nunset tics\nunset key\nset margins 0,0,0,0\n"
      "set xrange [-0.5:%d.5]\nset yrange [%d.5:-0.5]\n",
      width,
      height,
      width - 1,
      height - 1);
  script += words;
  script += Format("plot '-' binary array=(%d,%d) format='%%uchar' with rgbimage\n", width, height);
  script.append(page.rgb.begin(), page.rgb.end());
  return RunGnuplot(script);
}

}  // namespace vantage
