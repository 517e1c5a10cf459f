#pragma once

#include <string>

namespace vantage {

/// printf into a string, checked by the compiler.
[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...);

}  // namespace vantage
