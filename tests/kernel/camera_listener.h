#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/live_bus.h"
#include "vantage/camera_status_v2_t.hpp"
#include "vantage/images_t.hpp"

namespace vantage {

/// Hears what a camera process publishes.
class CameraListener {
 public:
  struct Arrival {
    int64_t seq = -1;
    int64_t utime = 0;          ///< us since the epoch, of the exposure
    int64_t receive_utime = 0;  ///< us since the epoch
  };

  /// @param camera the <NAME> of CAMERA_<NAME>.
  explicit CameraListener(const std::string& camera);

  /// Listens until the condition holds. @return false: it did not within 10 s.
  bool ListenUntil(const std::function<bool()>& condition);
  void ListenFor(std::chrono::milliseconds duration);
  /// Listens until so many more images came.
  bool ListenForImages(size_t count);
  bool ListenForState(int8_t state);
  /// Until a status says what contains the text.
  bool ListenForMessage(const std::string& text);

  /// Changes a control of the camera by its name.
  void SendControl(const std::string& name, int64_t value);
  void SendRestart();

  [[nodiscard]] const std::vector<Arrival>& arrivals() const { return arrivals_; }
  /// Messages missing between the first image and the last.
  [[nodiscard]] int64_t NumLost() const;
  /// The last message with images.
  [[nodiscard]] const images_t& images() const { return images_; }
  /// The last status.
  [[nodiscard]] const camera_status_v2_t& status() const { return status_; }
  /// State and counters, to be shown when a test fails.
  [[nodiscard]] std::string Summary() const;

 private:
  std::string channel_;
  std::unique_ptr<LiveBus> bus_;
  std::vector<Arrival> arrivals_;
  images_t images_{};
  camera_status_v2_t status_{};
};

}  // namespace vantage
