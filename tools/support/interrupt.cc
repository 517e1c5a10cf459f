#include "tools/support/interrupt.h"

#include <unistd.h>

#include <cstdio>
#include <thread>

namespace vantage {

Interrupt::Interrupt(const std::string& what) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::thread([signals, what, source = source_]() mutable {
    int signal = 0;
    sigwait(&signals, &signal);
    std::fprintf(stderr, "\nending after %s; once more to end at once\n", what.c_str());
    source.request_stop();
    sigwait(&signals, &signal);
    _exit(128 + signal);
  }).detach();
}

}  // namespace vantage
