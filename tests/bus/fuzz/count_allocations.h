#pragma once

#include <cstddef>

namespace vantage {

/// Bytes that operator new gave out since the program started, in all threads.
size_t BytesAllocated();

}  // namespace vantage
