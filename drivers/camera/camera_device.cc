#include "drivers/camera/camera_device.h"

#include <thread>

namespace vantage {
namespace {

template <class Clock>
int64_t Microseconds() {
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch())
      .count();
}

}  // namespace

int64_t CameraDeviceApi::MonotonicUs() { return Microseconds<std::chrono::steady_clock>(); }

int64_t CameraDeviceApi::WallUs() { return Microseconds<std::chrono::system_clock>(); }

void CameraDeviceApi::Sleep(std::chrono::microseconds duration) {
  std::this_thread::sleep_for(duration);
}

}  // namespace vantage
