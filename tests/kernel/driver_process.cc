#include "tests/kernel/driver_process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace vantage {

DriverProcess::DriverProcess(const std::string& config) {
  static int number = 0;
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const std::string stem =
      "kernel_test." + std::to_string(getpid()) + "." + std::to_string(number++);
  const std::string config_file = folder / (stem + ".toml");
  log_file_ = folder / (stem + ".log");
  std::ofstream(config_file) << config;
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "vantage-v4l2";
  const std::string name = "driver-" + std::to_string(number);
  pid_ = fork();
  if (pid_ != 0) return;
  const int log = open(log_file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execl(program.c_str(),
        program.c_str(),
        "--config",
        config_file.c_str(),
        "--name",
        name.c_str(),
        nullptr);
  _exit(127);
}

DriverProcess::~DriverProcess() {
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool DriverProcess::IsRunning() {
  if (pid_ < 0 || waitpid(pid_, nullptr, WNOHANG) == 0) return pid_ >= 0;
  pid_ = -1;
  return false;
}

int DriverProcess::Stop() {
  if (pid_ < 0) return -1;
  kill(pid_, SIGTERM);
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string DriverProcess::Output() const {
  std::ostringstream text;
  text << std::ifstream(log_file_).rdbuf();
  return text.str();
}

}  // namespace vantage
