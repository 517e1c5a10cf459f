#pragma once

#include <Driver/OniDriverAPI.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "common/camera_model.h"
#include "drivers/sim/openni2_abilities.h"

namespace vantage {

/// The video modes of a sensor: full and half resolution at 30 fps.
std::vector<OniVideoMode> SimVideoModes(OniSensorType sensor,
                                        const CameraModel& camera,
                                        const SimAbilities& abilities);

/// What is wrong with a frame.
struct SimFrameFaults {
  bool is_short = false;     ///< only the first half of the bytes
  bool has_no_data = false;  ///< no bytes at all
  bool is_resized = false;   ///< half the width
  bool is_absurd = false;    ///< claims sizes that no image has
};

/// One image stream of the simulated device, as OpenNI2 sees it.
class SimStream : public oni::driver::StreamBase {
 public:
  /// @param started called after the stream starts.
  SimStream(OniSensorType sensor,
            const CameraModel& camera,
            const SimAbilities& abilities,
            std::function<void()> started);

  OniStatus start() override;
  void stop() override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;
  OniBool isPropertySupported(int property) override;

  [[nodiscard]] OniSensorType sensor() const { return sensor_; }
  [[nodiscard]] bool started() const { return started_; }
  /// px, of the video mode.
  [[nodiscard]] int width();
  /// Hands a whole image of the video mode to OpenNI2, cropped and mirrored as was asked.
  /// @param pixels width * height pixels; `bytes` of them altogether.
  /// @param timestamp us since the device's start.
  void Deliver(const void* pixels,
               size_t bytes,
               uint64_t timestamp,
               int index,
               const SimFrameFaults& faults);

 private:
  OniStatus SetCropping(const OniCropping& cropping);
  OniStatus SetVideoMode(const OniVideoMode& mode);
  [[nodiscard]] int BytesPerPixel() const;
  [[nodiscard]] bool CannotStopMirroring() const;
  bool FillFrame(const uint8_t* pixels, size_t bytes, OniFrame* frame);
  void Spoil(const SimFrameFaults& faults, OniFrame* frame);
  void CopyPixels(const uint8_t* pixels, const OniFrame& frame) const;

  const OniSensorType sensor_;
  const CameraModel camera_;
  const SimAbilities abilities_;
  const std::function<void()> on_start_;
  std::atomic<bool> started_ = false;
  // Held while a frame is handed over, so that none comes after stop(); whoever hears of the frame
  // may call stop() on the same thread.
  std::recursive_mutex delivering_;
  std::mutex mutex_;  // Guards what follows.
  OniVideoMode mode_;
  OniCropping cropping_{};
  OniBool mirroring_;
  // Pixels of frames that went out without them; OpenNI2 would have freed them with the frames.
  std::vector<std::unique_ptr<void, decltype(&std::free)>> withheld_;
};

}  // namespace vantage
