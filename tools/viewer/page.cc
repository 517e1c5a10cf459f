#include "tools/viewer/page.h"

#include <algorithm>

#include "tools/support/rgb_canvas.h"

namespace vantage {

double TextWidth(const PageText& text) {
  const double letter = 0.52;  // Of the font's height.
  return letter * text.size_px * static_cast<double>(text.text.size());
}

std::string PrintableText(const std::string& text, size_t length) {
  std::string printable = text.substr(0, length);
  for (char& c : printable) {
    if (c < 0x20 || c == 0x7f) c = '?';
  }
  if (text.size() > length && length > 3) printable.replace(length - 3, 3, "...");
  return printable;
}

void FillBox(const PixelBox& box, Rgb color, RgbImage& image) {
  const int right = std::min(box.right(), image.width);
  const int bottom = std::min(box.bottom(), image.height);
  for (int v = std::max(0, box.y); v < bottom; ++v) {
    for (int u = std::max(0, box.x); u < right; ++u) SetPixel(image, u, v, color);
  }
}

void Paste(const RgbImage& part, int x, int y, RgbImage& image) {
  for (int v = 0; v < part.height; ++v) {
    for (int u = 0; u < part.width; ++u) SetPixel(image, x + u, y + v, PixelAt(part, u, v));
  }
}

double DrawScale(double x,
                 double y,
                 const std::string& low,
                 const std::string& high,
                 Rgb (*color)(double),
                 Page* page) {
  constexpr int kWidth = 70;   // px
  constexpr int kHeight = 10;  // px
  constexpr double kGap = 6.0;
  page->texts.push_back({x, y, low, 12, kFaintInk});
  const int left = static_cast<int>(x + TextWidth(page->texts.back()) + kGap);
  for (int u = 0; u < kWidth; ++u) {
    FillBox({left + u, static_cast<int>(y) - kHeight / 2, 1, kHeight},
            color(static_cast<double>(u) / (kWidth - 1)),
            page->image);
  }
  page->texts.push_back({left + kWidth + kGap, y, high, 12, kFaintInk});
  return page->texts.back().x + TextWidth(page->texts.back());
}

}  // namespace vantage
