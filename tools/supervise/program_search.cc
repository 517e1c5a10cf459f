#include "tools/supervise/program_search.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>
#include <system_error>

namespace vantage {

namespace fs = std::filesystem;

std::optional<fs::path> ExecutableFile(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error) || ::access(file.c_str(), X_OK) != 0) return std::nullopt;
  return fs::absolute(file).lexically_normal();
}

std::optional<fs::path> FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "/usr/bin:/bin:/usr/sbin" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (folder.empty()) continue;
    if (std::optional<fs::path> found = ExecutableFile(fs::path(folder) / name)) return found;
  }
  return std::nullopt;
}

}  // namespace vantage
