#pragma once

#include <string>

#include "tools/evaluate/confusion_results.h"

namespace vantage {

/// What came out, for the terminal.
std::string ConfusionText(const ConfusionResults& results);

/// "median (quartile..quartile)" of errors in degrees, those missing at 180.
std::string ErrorsText(const std::vector<double>& errors_deg);

/// Everything but the pictures.
std::string ConfusionJson(const ConfusionResults& results);
/// A line for each object, k, method and circle: its final error.
std::string ReweightingCsv(const ConfusionResults& results);
/// A line for each object, strategy and sequence: views until the right mode holds.
std::string ViewsNeededCsv(const ConfusionResults& results);
/// A line for each object, strategy and view: quartiles of the errors (Fig. 18).
std::string StepsCsv(const ConfusionResults& results);

}  // namespace vantage
