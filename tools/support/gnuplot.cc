#include "tools/support/gnuplot.h"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "common/format.h"

namespace vantage {
namespace {

// A file in memory: a child may fill it at any pace, as it could not with a pipe.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : descriptor_(memfd_create(name, MFD_CLOEXEC)) {}
  ~MemoryFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] bool Write(const std::string& text) const {
    size_t done = 0;
    while (done < text.size()) {
      const ssize_t wrote = write(descriptor_, text.data() + done, text.size() - done);
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote <= 0) return false;
      done += static_cast<size_t>(wrote);
    }
    return lseek(descriptor_, 0, SEEK_SET) == 0;
  }
  [[nodiscard]] std::string ReadAll() const {
    std::string text;
    std::array<char, 65536> chunk{};
    off_t offset = 0;
    for (;;) {
      const ssize_t got = pread(descriptor_, chunk.data(), chunk.size(), offset);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return text;
      text.append(chunk.data(), static_cast<size_t>(got));
      offset += got;
    }
  }

 private:
  int descriptor_;
};

// Starts `program`, waits for its end. Returns 0 and its wait status, or the error of the start.
int SpawnAndWait(const std::string& program,
                 const MemoryFile& input,
                 const MemoryFile& output,
                 const MemoryFile& complaints,
                 int* status) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.descriptor(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output.descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, complaints.descriptor(), STDERR_FILENO);
  std::string name = program;
  std::array<char*, 2> arguments = {name.data(), nullptr};
  pid_t child = 0;
  const int error =
      posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return error;
  while (waitpid(child, status, 0) < 0) {
    if (errno != EINTR) return errno;
  }
  return 0;
}

}  // namespace

Result<std::string> RunGnuplot(const std::string& script, const std::string& program) {
  const MemoryFile input("script");
  const MemoryFile output("figure");
  const MemoryFile complaints("complaints");
  if (complaints.descriptor() < 0 || output.descriptor() < 0 || !input.Write(script)) {
    return Error{ErrorCode::kIo,
                 Format("the system refuses memory for a figure: %s", std::strerror(errno))};
  }
  int status = 0;
  const int error = SpawnAndWait(program, input, output, complaints, &status);
  if (error == ENOENT) {
    return Error{ErrorCode::kNotFound,
                 program +
                     " draws the figures and is not installed; install it: "
                     "apt-get install gnuplot-nox"};
  }
  if (error != 0) {
    return Error{ErrorCode::kUnavailable,
                 Format("%s does not start: %s", program.c_str(), std::strerror(error))};
  }
  std::string figure = output.ReadAll();
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || figure.empty()) {
    return Error{ErrorCode::kIo,
                 Format("%s failed on a figure: %s",
                        program.c_str(),
                        complaints.ReadAll().substr(0, 400).c_str())};
  }
  return figure;
}

}  // namespace vantage
