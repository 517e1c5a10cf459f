#pragma once

#include <memory>
#include <string>

#include "common/result.h"

namespace vantage {

/// Keeps a second process of the same name off an LCM URL, as long as it lives; a killed process
/// leaves nothing that must be cleaned up. Processes see each other where their messages may meet:
/// in one network namespace, whoever runs them.
class ProcessNameLock {
 public:
  /// Errors: the name is held (with the holder's process id, if it can be known, and how to mend
  /// it), is not of letters, digits, '_', '-' and '.', or the system refuses.
  /// @param url LCM's; empty: as LiveBus has it. Options after '?' make no difference.
  static Result<std::unique_ptr<ProcessNameLock>> Acquire(const std::string& name,
                                                          const std::string& url);
  ~ProcessNameLock();
  ProcessNameLock(const ProcessNameLock&) = delete;
  ProcessNameLock& operator=(const ProcessNameLock&) = delete;

 private:
  explicit ProcessNameLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;
};

}  // namespace vantage
