#pragma once

#include <string>

#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// Everything in the results, as JSON under the names of the structs' members. NaN is null, doubles
/// read back as they were; what is no UTF-8 in a name is replaced.
std::string ResultsJson(const EvaluationResults& results);

}  // namespace vantage
