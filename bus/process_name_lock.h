#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/result.h"

namespace vantage {

/// Keeps a second process of the same name off an LCM URL, as long as it lives; a killed process
/// leaves nothing that must be cleaned up. Processes of other users and in other network namespaces
/// do not see each other.
class ProcessNameLock {
 public:
  /// Errors: the name is held (with the holder's process id and how to mend it), is not of letters,
  /// digits, '_', '-' and '.', or the folder for locks can't be used.
  /// @param url LCM's; empty: as LiveBus has it. Options after '?' make no difference.
  static Result<std::unique_ptr<ProcessNameLock>> Acquire(const std::string& name,
                                                          const std::string& url);
  ~ProcessNameLock();
  ProcessNameLock(const ProcessNameLock&) = delete;
  ProcessNameLock& operator=(const ProcessNameLock&) = delete;

 private:
  ProcessNameLock(std::filesystem::path file, int descriptor)
      : file_(std::move(file)), descriptor_(descriptor) {}

  std::filesystem::path file_;
  int descriptor_;
};

}  // namespace vantage
