#pragma once

#include <sys/types.h>

#include "common/result.h"

namespace vantage {

/// An X server without a screen (Xvfb), for drawing where there is none.
class VirtualDisplay {
 public:
  /// Starts one on a free display, and sets DISPLAY to it. Errors: Xvfb is not installed, or does
  /// not start.
  static Result<VirtualDisplay> Start(int width, int height);
  /// Ends it.
  ~VirtualDisplay();
  VirtualDisplay(VirtualDisplay&& other) noexcept : process_(other.process_) {
    other.process_ = -1;
  }
  VirtualDisplay& operator=(VirtualDisplay&&) = delete;

 private:
  explicit VirtualDisplay(pid_t process) : process_(process) {}
  pid_t process_;
};

/// An X server answers at DISPLAY. Errors: it is not set, or none does.
Result<void> CheckDisplay();

}  // namespace vantage
