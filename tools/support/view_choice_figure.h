#pragma once

#include <string>

#include "common/result.h"
#include "tools/support/color.h"
#include "vantage/next_view_t.hpp"

namespace vantage {

/// A map of the hemisphere of views (straight down in the middle, level views at the rim, azimuth 0
/// to the right) with every candidate of a decision: colored by what it promises, small and grey
/// where it was rejected, a ring around the selected one. As SVG; empty without candidates.
/// Errors: gnuplot.
Result<std::string> ViewChoiceFigure(const next_view_t& decision);

/// Of how many candidates the decision was made, and of those rejected how many for which reason,
/// the most frequent first; empty without candidates.
std::string RejectionText(const next_view_t& decision);

}  // namespace vantage
