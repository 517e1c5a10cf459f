#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tools/support/color.h"
#include "tools/support/png_image.h"

namespace vantage {

/// A rectangle of pixels; (0, 0) is at the upper left.
struct PixelBox {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  [[nodiscard]] int right() const { return x + width; }
  [[nodiscard]] int bottom() const { return y + height; }
  bool operator==(const PixelBox&) const = default;
};

enum class TextSide { kLeft, kCenter, kRight };

/// One line of text.
struct PageText {
  double x = 0.0;  ///< px, of the text's left end, middle or right end
  double y = 0.0;  ///< px, of the middle of the line
  std::string text;
  int size_px = 14;  ///< height of the font
  Rgb color;
  TextSide side = TextSide::kLeft;
  bool bold = false;
};

/// What the window shows besides the scene: a picture, and texts for whoever has fonts.
struct Page {
  RgbImage image;
  std::vector<PageText> texts;
};

inline constexpr Rgb kInk{36, 40, 50};
inline constexpr Rgb kFaintInk{112, 118, 130};
inline constexpr Rgb kPaper{255, 255, 255};
inline constexpr Rgb kSceneBackground{244, 245, 248};
inline constexpr Rgb kRule{222, 224, 230};

/// Width of a text, about: letters are narrower than they are high.
double TextWidth(const PageText& text);
/// What steers terminals or is no ASCII becomes '?'; more than `length` characters end in "...".
std::string PrintableText(const std::string& text, size_t length);

void FillBox(const PixelBox& box, Rgb color, RgbImage& image);
/// Copies `part` to where its upper left corner is at (x, y).
void Paste(const RgbImage& part, int x, int y, RgbImage& image);
/// A color bar with its ends' texts beside it. Returns x after it.
double DrawScale(double x,
                 double y,
                 const std::string& low,
                 const std::string& high,
                 Rgb (*color)(double),
                 Page* page);

}  // namespace vantage
