#include "tools/support/shown_progress.h"

#include <unistd.h>

#include <chrono>
#include <iostream>
#include <utility>

namespace vantage {
namespace {

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

ShownProgress::ShownProgress(std::string what) : what_(std::move(what)) {}

ShownProgress::~ShownProgress() {
  if (bar_) bar_->Finish();
}

void ShownProgress::Show(int64_t done, int64_t total) {
  if (!bar_) {
    bar_ =
        std::make_unique<ProgressBar>(std::cerr, what_, total, isatty(STDERR_FILENO) != 0, Now());
  }
  bar_->Show(done, Now());
}

}  // namespace vantage
