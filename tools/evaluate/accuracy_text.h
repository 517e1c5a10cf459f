#pragma once

#include <string>

#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// Accuracy and time of every method, as lines for a console, and how the compared methods differ
/// from the best variant of ours that is told no symmetry. Empty without sequences.
std::string AccuracyText(const EvaluationResults& results);

}  // namespace vantage
