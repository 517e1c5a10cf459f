#include "bus/process_name_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "bus/lcm_url.h"
#include "common/format.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// FNV-1a.
uint64_t HashText(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

// The network namespace: equal URLs in two of them are different places.
std::string Network() {
  std::error_code error;
  return fs::read_symlink("/proc/self/ns/net", error).string();
}

Result<fs::path> LockFolder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  const fs::path folder = runtime != nullptr && *runtime == '/'
                              ? fs::path(runtime) / "vantage"
                              : fs::path(Format("/tmp/vantage-%u", geteuid()));
  if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return Error{ErrorCode::kIo,
                 Format("folder %s for the locks of process names can't be made: %s",
                        folder.c_str(),
                        std::strerror(errno))};
  }
  struct stat status {};
  const bool is_ours = lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
                       status.st_uid == geteuid() && (status.st_mode & 0022U) == 0;
  if (!is_ours) {
    return Error{ErrorCode::kUnavailable,
                 Format("%s is not a folder that belongs to user %u alone, expected one with mode "
                        "0700; remove it: rm -r %s",
                        folder.c_str(),
                        geteuid(),
                        folder.c_str())};
  }
  return folder;
}

bool IsName(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  });
}

std::string ReadHolder(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t size = pread(descriptor, text.data(), text.size() - 1, 0);
  const long pid = size > 0 ? std::strtol(text.data(), nullptr, 10) : 0;
  return pid > 0 ? std::to_string(pid) : "unknown";
}

// True when `file` still is what `descriptor` opened: a holder that ended has removed its file.
bool IsStillThere(const fs::path& file, int descriptor) {
  struct stat opened {};
  struct stat present {};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &present) == 0 &&
         opened.st_ino == present.st_ino && opened.st_dev == present.st_dev;
}

}  // namespace

Result<std::unique_ptr<ProcessNameLock>> ProcessNameLock::Acquire(const std::string& name,
                                                                  const std::string& url) {
  if (!IsName(name)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("process name is '%.80s', expected 1 to 64 letters, digits, '_', '-' or '.'",
               name.c_str())};
  }
  Result<LcmUrl> parsed = LcmUrl::ParseOrDefault(url);
  if (!parsed) return parsed.error();
  const Result<fs::path> folder = LockFolder();
  if (!folder) return folder.error();
  const std::string place = parsed->Place();
  const auto hash = static_cast<unsigned long long>(HashText(place + ' ' + Network()));
  const fs::path file = *folder / Format("%s-%016llx.lock", name.c_str(), hash);

  while (true) {
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (descriptor < 0) {
      return Error{ErrorCode::kIo,
                   Format("lock %s can't be opened: %s", file.c_str(), std::strerror(errno))};
    }
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      const std::string holder = ReadHolder(descriptor);
      close(descriptor);
      return Error{ErrorCode::kUnavailable,
                   Format("a process named '%s' is on %s already (pid %s), expected one of each "
                          "name; end it with: kill %s, or start this one with --name OTHER",
                          name.c_str(),
                          place.c_str(),
                          holder.c_str(),
                          holder.c_str())};
    }
    if (IsStillThere(file, descriptor)) {
      const std::string pid = std::to_string(getpid()) + "\n";
      // Only for the message above, so a full disk does no harm.
      if (ftruncate(descriptor, 0) == 0) {
        [[maybe_unused]] const ssize_t written = pwrite(descriptor, pid.data(), pid.size(), 0);
      }
      return std::unique_ptr<ProcessNameLock>(new ProcessNameLock(file, descriptor));
    }
    close(descriptor);
  }
}

ProcessNameLock::~ProcessNameLock() {
  unlink(file_.c_str());  // While the lock is held: who opened it meanwhile sees that it is gone.
  close(descriptor_);
}

}  // namespace vantage
