#include "tools/monitor/terminal.h"

#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cstdio>

namespace vantage {
namespace {

void Write(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

const char* Sequence(ScreenLine::Style style) {
  switch (style) {
    case ScreenLine::Style::kPlain:
      return "";
    case ScreenLine::Style::kHeading:
      return "\033[1m";
    case ScreenLine::Style::kWrong:
      return "\033[31m";
    case ScreenLine::Style::kSelected:
      return "\033[7m";
  }
  return "";
}

}  // namespace

Terminal::Terminal() {
  tcgetattr(STDIN_FILENO, &before_);
  termios raw = before_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;  // Stopped, it would leave the terminal as it is now.
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  Write("\033[?1049h\033[?25l");  // A screen of its own, no cursor.
}

Terminal::~Terminal() {
  Write("\033[0m\033[?25h\033[?1049l");
  tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

bool Terminal::IsThere() { return isatty(STDIN_FILENO) != 0 && isatty(STDOUT_FILENO) != 0; }

ScreenSize Terminal::size() const {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_col == 0) {
    return {};
  }
  return {size.ws_row, size.ws_col};
}

std::string Terminal::ReadKeys() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (poll(&input, 1, 0) <= 0) return {};
  std::array<char, 256> keys{};
  const ssize_t got = read(STDIN_FILENO, keys.data(), keys.size());
  // Nothing where there was something: the terminal has gone.
  if (got <= 0) return "q";
  return {keys.data(), static_cast<size_t>(got)};
}

void Terminal::Show(const std::vector<ScreenLine>& lines) {
  std::string text = "\033[H";
  for (size_t i = 0; i < lines.size(); ++i) {
    text += Sequence(lines[i].style);
    text += lines[i].text;
    text += "\033[0m\033[K";
    if (i + 1 < lines.size()) text += "\r\n";
  }
  text += "\033[J";
  Write(text);
}

}  // namespace vantage
