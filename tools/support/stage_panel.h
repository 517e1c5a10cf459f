#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/support/color.h"
#include "tools/support/png_image.h"

namespace vantage {

/// A picture with a title above, words on it, and a legend below.
struct StagePanel {
  struct Label {
    double u = 0.0;  ///< px of the image, where the text's middle is
    double v = 0.0;  ///< px
    std::string text;
    Rgb color;
  };
  struct Note {
    std::optional<Rgb> color;  ///< of the swatch before the text
    std::string text;
  };
  std::string title;
  RgbImage image;
  std::vector<Label> labels;
  std::vector<Note> legend;  ///< Two lines of it at most.
};

}  // namespace vantage
