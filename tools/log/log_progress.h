#pragma once

#include <cstdint>
#include <optional>

#include "tools/support/shown_progress.h"

namespace vantage {

/// How far a pass over logs is, in MB, on a terminal; silent elsewhere.
class LogProgress {
 public:
  explicit LogProgress(int64_t total_bytes);
  void Show(int64_t done_bytes);

 private:
  int64_t total_;
  int64_t next_;  // Bytes with which it is worth looking at the clock.
  std::optional<ShownProgress> bar_;
};

}  // namespace vantage
