#pragma once

#include <termios.h>

#include <string>
#include <vector>

#include "tools/monitor/monitor_screen.h"

namespace vantage {

/// The terminal that the program runs in, for as long as this lives: keys come as they are typed,
/// and what was on the screen before comes back at the end.
class Terminal {
 public:
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Standard input and output are a terminal.
  static bool IsThere();
  /// 24 x 80 where the terminal does not say.
  [[nodiscard]] ScreenSize size() const;
  /// What was typed since the last time.
  std::string ReadKeys();
  void Show(const std::vector<ScreenLine>& lines);

 private:
  termios before_{};
};

}  // namespace vantage
