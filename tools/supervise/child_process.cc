#include "tools/supervise/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "common/format.h"

namespace vantage {
namespace {

Error Refused(const std::string& program, int reason) {
  return {ErrorCode::kIo,
          Format("%s can't be started: %s", program.c_str(), std::strerror(reason))};
}

// In the child, where nothing may be allocated.
[[noreturn]] void Become(char* const* words, int output) {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  const int null = open("/dev/null", O_RDONLY);
  if (null >= 0) dup2(null, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  execv(words[0], words);
  _exit(127);
}

}  // namespace

Result<ChildProcess> StartChild(const std::vector<std::string>& words) {
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return Refused(words.front(), errno);
  const pid_t pid = fork();
  if (pid == 0) Become(pointers.data(), ends[1]);
  const int reason = errno;
  close(ends[1]);
  if (pid > 0) return ChildProcess{pid, ends[0]};
  close(ends[0]);
  return Refused(words.front(), reason);
}

int WaitForChild(const ChildProcess& child) {
  close(child.output);
  int status = 0;
  while (waitpid(child.pid, &status, 0) < 0 && errno == EINTR) {
  }
  constexpr int kSignalOffset = 128;  // As shells tell it.
  return WIFSIGNALED(status) ? kSignalOffset + WTERMSIG(status) : WEXITSTATUS(status);
}

Result<ChildOutput> RunChild(const std::vector<std::string>& words) {
  const Result<ChildProcess> child = StartChild(words);
  if (!child) return child.error();
  ChildOutput output;
  std::array<char, 4096> buffer{};
  for (;;) {
    const ssize_t got = read(child->output, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    output.text.append(buffer.data(), static_cast<size_t>(got));
  }
  output.exit_code = WaitForChild(*child);
  return output;
}

}  // namespace vantage
