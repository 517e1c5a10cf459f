#include "perception/model/isolated_work.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <string_view>

#include "common/format.h"

namespace vantage {
namespace {

bool WriteAll(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return true;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
void LimitMemory(size_t /*bytes*/) {}
#else
// Beyond the address space that the process has already.
void LimitMemory(size_t bytes) {
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  if (!(statm >> pages)) return;
  const rlim_t limit = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + bytes;
  const rlimit memory{limit, limit};
  ::setrlimit(RLIMIT_AS, &memory);
}
#endif

// The child's life: quiet, without a core file, and not for ever.
[[noreturn]] void Work(const std::function<std::string()>& work,
                       const IsolationLimits& limits,
                       int output) {
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const int quiet = ::open("/dev/null", O_WRONLY);
  if (quiet >= 0) ::dup2(quiet, STDERR_FILENO);
  for (const int signal : {SIGABRT, SIGSEGV, SIGALRM}) ::signal(signal, SIG_DFL);
  LimitMemory(limits.memory);
  ::alarm(limits.seconds);
  ::_exit(WriteAll(output, work()) ? 0 : 1);
}

Result<std::string> ReadBack(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) {
    return Error{ErrorCode::kIo, Format("child process: %s", std::strerror(errno))};
  }
  std::string bytes(static_cast<size_t>(status.st_size), '\0');
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        ::pread(descriptor, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Error{ErrorCode::kIo, "child process: its result can't be read"};
    done += static_cast<size_t>(got);
  }
  return bytes;
}

}  // namespace

Result<std::string> RunIsolated(const std::function<std::string()>& work,
                                const IsolationLimits& limits) {
  const int output = ::memfd_create("vantage-isolated", MFD_CLOEXEC);
  if (output < 0) {
    return Error{ErrorCode::kIo, Format("child process: %s", std::strerror(errno))};
  }
  const pid_t child = ::fork();
  if (child == 0) Work(work, limits, output);
  int status = 0;
  pid_t ended = child;
  if (child > 0) {
    do {
      ended = ::waitpid(child, &status, 0);
    } while (ended < 0 && errno == EINTR);
  }
  Result<std::string> bytes = Error{ErrorCode::kIo, "child process: it failed"};
  if (child < 0 || ended < 0) {
    bytes = Error{ErrorCode::kIo, Format("child process: %s", std::strerror(errno))};
  } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) {
    bytes = Error{ErrorCode::kCorrupt, Format("not done after %u s", limits.seconds)};
  } else if (WIFSIGNALED(status)) {
    bytes = Error{ErrorCode::kCorrupt, Format("died of signal %d", WTERMSIG(status))};
  } else if (WEXITSTATUS(status) == 0) {
    bytes = ReadBack(output);
  }
  ::close(output);
  return bytes;
}

}  // namespace vantage
