#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "tests/drivers/v4l2_shim/description.h"
#include "tests/drivers/v4l2_shim/emulated_file.h"

namespace vantage::v4l2_shim {

/// All that this process sees of the emulated devices. Used through Session.
class Emulator {
 public:
  /// Reads the description again where it has changed.
  void Refresh(const std::string& description_file);

  /// Where `path`, seen from the folder `dirfd`, really is; nothing for names that are not
  /// emulated.
  std::optional<std::string> Redirect(int dirfd, const std::string& path, bool as_folder = false);
  /// Takes the emulated root off a path.
  [[nodiscard]] std::string Public(const std::string& path) const;
  /// The device whose node the redirected path is; null: it is none or none is there.
  const Device* NodeAt(const std::string& redirected);

  /// @return a descriptor, or -1 with errno.
  int Open(const Device& device, int flags);
  /// The errno that opening fails with now; 0: it succeeds.
  int OpenError(const Device& device);
  /// True while any device is open; of any thread, without a Session.
  static bool HasFiles();
  EmulatedFile* File(int fd);
  void Close(int fd);

  /// 0 or an errno.
  int Ioctl(EmulatedFile* file, int fd, unsigned long request, void* argument);
  /// The file to map in the device's stead; -1 and errno: none.
  int BufferFile(EmulatedFile* file, size_t length, int64_t offset);
  short PollEvents(EmulatedFile* file);

 private:
  const Device* DeviceOf(const EmulatedFile& file) const;
  const Device* Numbered(int number) const;
  // The errno of a line "fail" that is for this call now; 0: none.
  int Failure(const Device& device, const std::string& call);

  std::string description_file_;
  struct stat seen_ {};
  std::filesystem::path root_;
  std::vector<Device> devices_;
  std::map<std::string, int> failures_;  // So far, by node and line.
  std::map<int, std::unique_ptr<EmulatedFile>> files_;
};

/// Holds the emulator for one call; calls that it makes itself go to the system.
class Session {
 public:
  /// Inactive without the environment's VANTAGE_V4L2_SHIM.
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  explicit operator bool() const { return lock_.owns_lock(); }
  Emulator* operator->() const;

 private:
  std::unique_lock<std::mutex> lock_;
};

}  // namespace vantage::v4l2_shim
