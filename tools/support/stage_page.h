#pragma once

#include <span>
#include <string>

#include "common/result.h"
#include "tools/support/stage_panel.h"

namespace vantage {

/// Places of panels on a page of three columns, px.
struct StageLayout {
  static constexpr int kColumns = 3;
  static constexpr int kPanelWidth = 512;
  static constexpr int kPanelHeight = 384;
  static constexpr int kGap = 16;
  static constexpr int kTitle = 30;
  static constexpr int kLegend = 46;

  /// Left upper corner of a panel's picture.
  static constexpr int Left(int panel) { return kGap + panel % kColumns * (kPanelWidth + kGap); }
  static constexpr int Top(int panel) {
    return kTitle + panel / kColumns * (kTitle + kPanelHeight + kLegend);
  }
  static constexpr int Width() { return kGap + kColumns * (kPanelWidth + kGap); }
  static constexpr int Height(int panels) {
    return (panels + kColumns - 1) / kColumns * (kTitle + kPanelHeight + kLegend);
  }
};

/// The panels as one PNG. Errors: as RunGnuplot, which sets the words.
/// @param panels whose pictures have the layout's size.
Result<std::string> RenderStagePage(std::span<const StagePanel> panels);

}  // namespace vantage
