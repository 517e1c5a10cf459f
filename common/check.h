#pragma once

#include <string_view>

namespace vantage {

/// Reports a programmer's error and stops the program.
[[noreturn]] void CheckFailed(const char* file,
                              int line,
                              const char* condition,
                              std::string_view detail);

}  // namespace vantage

/// Stops the program when an invariant fails. Never used on what comes from outside.
#define VANTAGE_CHECK(condition, detail)                              \
  do {                                                                \
    if (!(condition)) [[unlikely]] {                                  \
      ::vantage::CheckFailed(__FILE__, __LINE__, #condition, detail); \
    }                                                                 \
  } while (false)
