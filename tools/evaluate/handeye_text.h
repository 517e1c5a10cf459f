#pragma once

#include <string>

#include "tools/evaluate/handeye_results.h"

namespace vantage {

/// What came out, for the terminal.
std::string HandEyeText(const HandEyeResults& results);
/// A line for each method, setup, number of views and share of outliers.
std::string HandEyeCsv(const HandEyeResults& results);

}  // namespace vantage
