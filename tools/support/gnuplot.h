#pragma once

#include <string>

#include "common/result.h"

namespace vantage {

/// Runs gnuplot on a script (no shell between) and returns what it writes to its standard output:
/// with `set terminal svg` and no `set output`, the figure.
/// Errors: gnuplot is not installed, it refuses the script (its own words), it writes nothing.
/// @param program name searched on PATH; another one only in tests.
Result<std::string> RunGnuplot(const std::string& script, const std::string& program = "gnuplot");

}  // namespace vantage
