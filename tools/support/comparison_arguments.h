#pragma once

#include <CLI/CLI.hpp>

#include "tools/support/message_comparison.h"

namespace vantage {

/// Adds the tolerances of a comparison as options, in the group "Comparing". `tolerance` outlives
/// the parsing.
void AddToleranceArguments(CLI::App* app, ComparisonTolerance* tolerance);

}  // namespace vantage
