#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "tools/support/progress_bar.h"

namespace vantage {

/// A progress bar on standard error that appears with the first step and is timed by the clock.
class ShownProgress {
 public:
  /// @param what is counted: "views".
  explicit ShownProgress(std::string what);
  ~ShownProgress();
  ShownProgress(const ShownProgress&) = delete;
  ShownProgress& operator=(const ShownProgress&) = delete;

  void Show(int64_t done, int64_t total);

 private:
  std::string what_;
  std::unique_ptr<ProgressBar> bar_;
};

}  // namespace vantage
