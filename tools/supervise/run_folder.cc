#include "tools/supervise/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>

#include "common/format.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// "demo-1f2e3d4c": for people, and apart from other files of that name.
std::string IdOf(const fs::path& config) {
  constexpr size_t kLongest = 40;
  std::string id;
  for (const unsigned char c : config.stem().string().substr(0, kLongest)) {
    id += std::isalnum(c) != 0 || c == '-' || c == '_' ? static_cast<char>(c) : '_';
  }
  return id + Format("-%08x", static_cast<unsigned>(Fnv1a(config.string())));
}

fs::path FromEnvironment(const char* variable) {
  const char* text = std::getenv(variable);
  return text != nullptr && text[0] == '/' ? fs::path(text) : fs::path();
}

fs::path DefaultFolder(const std::string& id) {
  const fs::path runtime = FromEnvironment("XDG_RUNTIME_DIR");
  if (!runtime.empty()) return runtime / "vantage" / id;
  return fs::temp_directory_path() / Format("vantage-%u", static_cast<unsigned>(getuid())) / id;
}

fs::path DefaultLogs(const std::string& id, const fs::path& run_folder) {
  if (const fs::path state = FromEnvironment("XDG_STATE_HOME"); !state.empty()) {
    return state / "vantage" / id;
  }
  const fs::path home = FromEnvironment("HOME");
  return home.empty() ? run_folder / "logs" : home / ".local/state/vantage" / id;
}

// A comment begins where ';' or '#' follows a blank, and no quotes help.
bool FitsIntoSupervisorsFile(const std::string& path) {
  for (size_t i = 0; i < path.size(); ++i) {
    const auto c = static_cast<unsigned char>(path[i]);
    if (std::iscntrl(c) != 0) return false;
    if ((c == ';' || c == '#') && i > 0 && path[i - 1] == ' ') return false;
  }
  return !path.empty() && path.back() != ' ';
}

Result<sockaddr_un> AddressOf(const fs::path& socket) {
  constexpr size_t kPidText = 12;  // The supervisor binds SOCKET.PID first.
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = socket.string();
  if (path.size() + kPidText >= sizeof(address.sun_path)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("the run folder's socket %s has a path of %zu bytes, expected at most %zu; "
                        "choose a shorter one with --folder",
                        path.c_str(),
                        path.size(),
                        sizeof(address.sun_path) - kPidText - 1)};
  }
  std::ranges::copy(path, address.sun_path);
  return address;
}

Result<void> MakeFolder(const fs::path& folder, const char* what) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Error{
        ErrorCode::kIo,
        Format("the %s %s can't be made: %s", what, folder.c_str(), error.message().c_str())};
  }
  return {};
}

// A file is made in it and removed: rights alone do not tell of a full or read-only file system.
Result<void> CheckWritable(const fs::path& folder, const char* what) {
  const fs::path probe = folder / Format(".probe-%d", getpid());
  std::ofstream stream(probe);
  stream << std::string(4096, ' ') << std::flush;
  const int reason = errno;
  const bool written = stream.good();
  stream.close();
  std::error_code ignored;
  fs::remove(probe, ignored);
  if (written) return {};
  return Error{ErrorCode::kIo,
               Format("the %s %s can't be written: %s",
                      what,
                      folder.c_str(),
                      std::strerror(reason == 0 ? EIO : reason))};
}

Result<void> MakePrivate(const fs::path& folder) {
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) ||
      status.st_uid != getuid() || ::chmod(folder.c_str(), S_IRWXU) != 0) {
    return Error{ErrorCode::kUnavailable,
                 Format("the run folder %s is not a folder of yours, expected one; choose another "
                        "with --folder",
                        folder.c_str())};
  }
  return {};
}

}  // namespace

Result<RunFolder> ChooseRunFolder(const fs::path& config,
                                  const fs::path& chosen,
                                  const fs::path& logs) {
  RunFolder run;
  run.id = IdOf(config);
  run.folder = chosen.empty() ? DefaultFolder(run.id) : fs::absolute(chosen).lexically_normal();
  run.logs = logs.empty() ? DefaultLogs(run.id, run.folder) : logs;
  if (!FitsIntoSupervisorsFile(run.folder.string())) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("the run folder '%s' has a control character, ends in a blank, or has ';' or "
               "'#' after one, expected none of these; choose another with --folder",
               run.folder.c_str())};
  }
  if (const Result<sockaddr_un> address = AddressOf(run.socket()); !address) return address.error();
  return run;
}

Result<void> TakeRunFolder(const RunFolder& run) {
  if (Result<void> made = MakeFolder(run.folder, "run folder"); !made) return made;
  if (Result<void> made = MakePrivate(run.folder); !made) return made;
  if (Result<void> writable = CheckWritable(run.folder, "run folder"); !writable) return writable;
  // Stays open: the lock goes with the process.
  const int descriptor = ::open(run.folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return {};
  return Error{ErrorCode::kUnavailable,
               Format("another vantage-up is at work in %s, expected one for a configuration",
                      run.folder.c_str())};
}

Result<void> MakeLogFolder(const RunFolder& run) {
  if (Result<void> made = MakeFolder(run.logs, "log folder"); !made) return made;
  if (Result<void> writable = CheckWritable(run.logs, "log folder"); !writable) return writable;
  std::error_code error;
  fs::remove(run.log_link(), error);
  fs::create_directory_symlink(run.logs, run.log_link(), error);
  if (!error) return {};
  return Error{
      ErrorCode::kIo,
      Format("the link %s can't be made: %s", run.log_link().c_str(), error.message().c_str())};
}

bool IsUp(const RunFolder& run) {
  const Result<sockaddr_un> address = AddressOf(run.socket());
  const int descriptor = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (!address || descriptor < 0) return false;
  const bool served =
      ::connect(descriptor, reinterpret_cast<const sockaddr*>(&*address), sizeof(*address)) == 0;
  ::close(descriptor);
  return served;
}

}  // namespace vantage
