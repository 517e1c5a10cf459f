#include "tools/viewer/vtk/virtual_display.h"

#include <X11/Xlib.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string>

#include "common/format.h"

namespace vantage {
namespace {

constexpr int kStartTimeoutMs = 20'000;
constexpr int kNotInstalled = 127;  // Exit code of the child.

// In the child: becomes Xvfb, which writes its display's number to `number`.
[[noreturn]] void BecomeServer(int number, int width, int height) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // It shall not outlive the viewer.
  setsid();                          // Ctrl-C is the viewer's.
  sigset_t none;                     // What the viewer holds back is not held back from it.
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
  dup2(nowhere, STDIN_FILENO);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const std::string display = std::to_string(number);
  const std::string screen = Format("%dx%dx24", width, height);
  execlp("Xvfb",
         "Xvfb",
         "-displayfd",
         display.c_str(),
         "-screen",
         "0",
         screen.c_str(),
         "-nolisten",
         "tcp",
         nullptr);
  _exit(kNotInstalled);
}

// What Xvfb wrote up to the end of the line; empty when it wrote none in time.
std::string ReadLine(int from) {
  std::string line;
  while (line.size() < 16) {
    pollfd ready{from, POLLIN, 0};
    if (poll(&ready, 1, kStartTimeoutMs) <= 0) return {};
    char c = 0;
    if (read(from, &c, 1) != 1) return {};
    if (c == '\n') return line;
    line += c;
  }
  return {};
}

}  // namespace

Result<VirtualDisplay> VirtualDisplay::Start(int width, int height) {
  int ends[2];
  if (pipe(static_cast<int*>(ends)) != 0) {
    return Error{ErrorCode::kIo, Format("a pipe can't be made: %s", std::strerror(errno))};
  }
  fcntl(ends[0], F_SETFD, FD_CLOEXEC);
  const pid_t child = fork();
  if (child == 0) BecomeServer(ends[1], width, height);
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return Error{ErrorCode::kIo, Format("Xvfb can't be started: %s", std::strerror(errno))};
  }
  VirtualDisplay display(child);
  const std::string number = ReadLine(ends[0]);
  close(ends[0]);
  if (number.empty()) {
    int status = 0;
    if (waitpid(child, &status, WNOHANG) == child) display.process_ = -1;
    return Error{ErrorCode::kUnavailable,
                 "no X server to draw with: Xvfb did not start; apt-get install xvfb"};
  }
  setenv("DISPLAY", (':' + number).c_str(), 1);
  return display;
}

VirtualDisplay::~VirtualDisplay() {
  if (process_ <= 0) return;
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
}

Result<void> CheckDisplay() {
  const char* name = std::getenv("DISPLAY");
  if (name == nullptr || *name == '\0') {
    return Error{
        ErrorCode::kUnavailable,
        "DISPLAY is not set: there is no screen to show a window on; start it on a desktop, "
        "or use --offscreen for a picture or video"};
  }
  Display* display = XOpenDisplay(nullptr);
  if (display == nullptr) {
    return Error{ErrorCode::kUnavailable,
                 Format("no X server answers at DISPLAY=%s; start it on a desktop, or use "
                        "--offscreen for a picture or video",
                        name)};
  }
  XCloseDisplay(display);
  return {};
}

}  // namespace vantage
