#include "tools/log/log_progress.h"

#include <unistd.h>

#include <limits>

namespace vantage {
namespace {

constexpr int64_t kMegabyte = 1'000'000;

}  // namespace

LogProgress::LogProgress(int64_t total_bytes)
    : total_(total_bytes), next_(std::numeric_limits<int64_t>::max()) {
  if (isatty(STDERR_FILENO) == 0) return;
  bar_.emplace("MB");
  next_ = kMegabyte;
}

void LogProgress::Show(int64_t done_bytes) {
  if (done_bytes < next_) return;
  next_ = done_bytes + kMegabyte;
  bar_->Show(done_bytes / kMegabyte, total_ / kMegabyte);
}

}  // namespace vantage
