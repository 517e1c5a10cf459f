#include "tools/support/progress_bar.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

constexpr double kTerminalPeriod = 0.1;  // s, between lines.
constexpr double kFilePeriod = 10.0;     // s
constexpr double kMemory = 30.0;         // s, after which the rate counts for 1/e.
constexpr int kBarWidth = 24;            // Characters.

}  // namespace

ProgressBar::ProgressBar(
    std::ostream& stream, std::string what, int64_t total, bool is_terminal, double now)
    : stream_(stream),
      what_(std::move(what)),
      total_(std::max<int64_t>(total, 1)),
      is_terminal_(is_terminal),
      last_shown_(now),
      last_time_(now) {}

void ProgressBar::Show(int64_t done, double now) {
  Learn(done, now);
  const double period = is_terminal_ ? kTerminalPeriod : kFilePeriod;
  if (now - last_shown_ < period && done < total_) return;
  last_shown_ = now;
  if (is_terminal_) {
    stream_ << '\r' << Line(done) << "\033[K" << std::flush;
    is_line_open_ = true;
  } else {
    stream_ << Line(done) << std::endl;
  }
}

void ProgressBar::Finish() {
  if (is_line_open_) stream_ << std::endl;
  is_line_open_ = false;
}

void ProgressBar::Learn(int64_t done, double now) {
  const double passed = now - last_time_;
  if (!(passed > 0.0)) return;
  const double kept = std::exp(-passed / kMemory);
  recent_done_ = kept * recent_done_ + static_cast<double>(done - last_done_);
  recent_time_ = kept * recent_time_ + passed;
  last_done_ = done;
  last_time_ = now;
}

std::string ProgressBar::Line(int64_t done) const {
  const double share =
      std::clamp(static_cast<double>(done) / static_cast<double>(total_), 0.0, 1.0);
  const auto filled = static_cast<size_t>(share * kBarWidth);
  std::string line(1, '[');
  line.append(filled, '#').append(kBarWidth - filled, '.');
  line += Format("] %jd/%jd %s %3d %%",
                 static_cast<intmax_t>(done),
                 static_cast<intmax_t>(total_),
                 what_.c_str(),
                 static_cast<int>(100.0 * share));
  const double rate = recent_time_ > 0.0 ? recent_done_ / recent_time_ : 0.0;
  if (rate > 0.0) {
    line += Format(
        ", %.1f/s, %s left", rate, ClockText(static_cast<double>(total_ - done) / rate).c_str());
  }
  return line;
}

std::string ClockText(double seconds) {
  constexpr double kLongest = 359999.0;  // 99:59:59
  const auto whole = static_cast<int>(std::lround(std::clamp(seconds, 0.0, kLongest)));
  const int minutes = whole / 60;
  return minutes < 60 ? Format("%d:%02d", minutes, whole % 60)
                      : Format("%d:%02d:%02d", minutes / 60, minutes % 60, whole % 60);
}

}  // namespace vantage
