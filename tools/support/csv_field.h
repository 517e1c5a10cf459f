#pragma once

#include <string>
#include <string_view>

namespace vantage {

/// A value of a CSV file: with as many digits as bring it back, empty where it is not finite.
std::string CsvField(double value);
/// A text of a CSV file, in quotes where it must be.
std::string CsvField(std::string_view text);

}  // namespace vantage
