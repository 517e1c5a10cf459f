#pragma once

#include <cstdint>
#include <ostream>
#include <string>

namespace vantage {

/// How far long work is: one line with done and total, percent, rate and time left, written over in
/// place on a terminal, every ten seconds anew elsewhere. Time is passed in: s, of any start.
class ProgressBar {
 public:
  /// @param what is counted: "views".
  /// @param total > 0.
  /// @param is_terminal what the stream leads to.
  ProgressBar(std::ostream& stream, std::string what, int64_t total, bool is_terminal, double now);

  /// Writes when it is time to, and whenever all is done.
  void Show(int64_t done, double now);
  /// Ends the line, so that others may write below it.
  void Finish();

 private:
  void Learn(int64_t done, double now);
  [[nodiscard]] std::string Line(int64_t done) const;

  std::ostream& stream_;
  std::string what_;
  int64_t total_;
  bool is_terminal_;
  double last_shown_;
  bool is_line_open_ = false;
  // What was done lately, and how long that took, older parts counting less and less.
  double recent_done_ = 0.0;
  double recent_time_ = 0.0;  // s
  int64_t last_done_ = 0;
  double last_time_;
};

/// "0:07", "12:30", "1:02:05".
std::string ClockText(double seconds);

}  // namespace vantage
