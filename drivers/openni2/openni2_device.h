#pragma once

#include <OpenNI.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/camera/frame_pairing.h"
#include "drivers/openni2/device_events.h"
#include "drivers/openni2/device_lock.h"
#include "drivers/openni2/oni_recording.h"

namespace vantage {

/// CameraDevice through the OpenNI2 library.
class Openni2Device : public CameraDevice {
 public:
  /// `events` and `record` outlive the device. Errors: OpenNI2's own, with its words; another
  /// program is looking at the device for seconds.
  static Result<std::unique_ptr<CameraDevice>> Open(const std::string& uri,
                                                    DeviceEvents& events,
                                                    RecordTarget& record);
  ~Openni2Device() override;

  /// A recording was closed: its handles stay with the library, which must not be shut down then.
  static bool HasLeftRecordings();
  Openni2Device(const Openni2Device&) = delete;
  Openni2Device& operator=(const Openni2Device&) = delete;

  [[nodiscard]] std::string serial() const override;
  Result<StreamDetails> Start(const StreamRequest& request) override;
  ReadResult Read(std::chrono::milliseconds timeout, RawFrame* frame) override;
  Result<void> SetExposure(int exposure_us) override;
  Result<void> SetGain(int gain) override;
  Result<void> SetControl(const std::string& name, int64_t value) override;

  /// What the open device can do, a line for each sensor and one for the rest, for people.
  [[nodiscard]] std::string Describe();

 private:
  using Clock = std::chrono::steady_clock;
  enum class Stream { kDepth, kColor, kNone };

  Openni2Device(std::string uri, DeviceEvents& events, RecordTarget& record)
      : uri_(std::move(uri)), events_(events), record_(record) {}

  // Opening.
  [[nodiscard]] Error Refusal(const std::string& what) const;
  Result<void> StartDepth(const StreamRequest& request, StreamDetails* details);
  void StartColor(const StreamRequest& request, StreamDetails* details);
  void Register(const StreamRequest& request);
  void StartColorStream(StreamDetails* details);
  void PreparePlayback();

  // Reading.
  ReadResult ReadStreams(Clock::time_point deadline, Stream* read);
  ReadResult ReadDepth(Clock::time_point deadline);
  ReadResult ReadColorOfDepth();
  void FillFrame(RawFrame* frame);
  void StopSync();

  // Recording.
  void OpenRecording();
  void BeginRecording();
  void WatchRecording();

  Result<openni::CameraSettings*> ColorSettings();

  std::string uri_;  // As it was asked for.
  DeviceEvents& events_;
  RecordTarget& record_;
  std::unique_ptr<DeviceLock> lock_;  // Until it streams.
  struct Handles {
    openni::Device device;
    openni::VideoStream depth;
    openni::VideoStream color;
  };
  std::unique_ptr<Handles> handles_ = std::make_unique<Handles>();
  openni::Device& device_ = handles_->device;
  openni::VideoStream& depth_ = handles_->depth;
  openni::VideoStream& color_ = handles_->color;

  openni::VideoFrameRef depth_frame_;
  openni::VideoFrameRef next_depth_frame_;  // Came while color for depth_frame_ was waited for.
  std::array<openni::VideoFrameRef, FramePairing::kNumSlots> color_frames_;
  FramePairing pairing_{{}};
  std::optional<FramePairing::Match> match_;  // Of depth_frame_.
  int64_t depth_period_us_ = 33'333;
  bool wants_gray_ = false;
  bool flips_color_ = false;  // Color is mirrored and depth is not, or the other way round.
  std::vector<std::byte> color_pixels_;  // Where they had to be changed.

  bool is_synced_ = false;  // OpenNI2 gives depth only together with color.
  Clock::time_point last_frame_;
  std::string trouble_;                      // What went wrong besides, in one sentence.
  std::unique_ptr<OniRecording> recording_;  // Of what this device gives; null: none.
  int num_not_recorded_ = 0;                 // Depth images before it began.
  bool is_recording_ = false;                // The device itself is one.
  int num_frames_ = 0;                       // Of a recording; 0: it does not say.
  int num_read_ = 0;
  int num_color_frames_ = 0;  // Of a recording.
  int num_color_read_ = 0;
};

}  // namespace vantage
