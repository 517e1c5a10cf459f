#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/camera/camera_device.h"

namespace vantage {

/// Devices that do what a test says, on a clock that only moves when somebody waits.
class FakeHost {
 public:
  static constexpr int kWidth = 8;
  static constexpr int kHeight = 6;
  static constexpr int64_t kPeriodUs = 33'333;

  struct Plugged {
    std::string serial;
    bool refuses_to_open = false;
  };
  /// One entry is used up by every frame; when empty the frames are good.
  enum class Fault { kNone, kShort, kWrongSize, kWrongStride, kNoData, kMarked };

  std::map<std::string, Plugged> devices;  ///< by URI
  bool stalled = false;
  std::deque<Fault> faults;
  int frames_until_end = -1;  ///< of a recording
  StreamDetails details = Details();
  bool with_color = false;
  bool pressed_by_event = false;  ///< the next WaitForDevice() returns at once

  static StreamDetails Details() {
    StreamDetails details;
    details.width = kWidth;
    details.height = kHeight;
    details.horizontal_fov = 1.0;
    details.vertical_fov = 0.8;
    return details;
  }

  std::function<void()> on_time;  ///< called whenever the clock moves on, by who moved it

  void Pass(int64_t duration_us) {
    now_us += duration_us;
    if (on_time) on_time();
  }

  int64_t now_us = 1'000'000;
  int64_t wall_offset_us = 1'700'000'000'000'000;
  int64_t device_offset_us = 77'000'000;
  int num_opened = 0;
  int num_open = 0;
  int num_lists = 0;
  int frame_index = 0;
  int exposure_us = -1;
  int64_t white_balance = -1;
};

class FakeDevice : public CameraDevice {
 public:
  FakeDevice(FakeHost& host, std::string uri, std::string serial)
      : host_(host), uri_(std::move(uri)), serial_(std::move(serial)) {
    ++host_.num_opened;
    ++host_.num_open;
  }
  ~FakeDevice() override { --host_.num_open; }

  [[nodiscard]] std::string serial() const override { return serial_; }

  Result<StreamDetails> Start(const StreamRequest& request) override {
    if (!host_.details.is_recording && request.fps != 30) {
      return Error{ErrorCode::kNotFound, "no depth mode at that rate"};
    }
    return host_.details;
  }

  ReadResult Read(std::chrono::milliseconds timeout, RawFrame* frame) override {
    const int64_t timeout_us = std::chrono::microseconds(timeout).count();
    if (!host_.details.is_recording && !host_.devices.contains(uri_)) return ReadResult::kGone;
    if (host_.frames_until_end == 0) return ReadResult::kEnd;
    if (host_.frames_until_end > 0) --host_.frames_until_end;
    if (host_.stalled || timeout_us < FakeHost::kPeriodUs) {
      host_.Pass(timeout_us);
      return ReadResult::kTimeout;
    }
    if (!host_.details.is_recording) host_.Pass(FakeHost::kPeriodUs);
    if (!host_.faults.empty() && host_.faults.front() == FakeHost::Fault::kMarked) {
      host_.faults.pop_front();
      *frame = {.depth = {}, .color = {}, .index = ++host_.frame_index, .fault = "marked as bad"};
      return ReadResult::kBad;
    }
    FillFrame(frame);
    return ReadResult::kFrame;
  }

  Result<void> SetExposure(int exposure_us) override {
    host_.exposure_us = exposure_us;
    return {};
  }
  Result<void> SetControl(const std::string& name, int64_t value) override {
    if (name != "white_balance") return Error{ErrorCode::kNotFound, "no control " + name};
    host_.white_balance = value;
    return {};
  }
  Result<void> SetGain(int) override {
    return Error{ErrorCode::kUnavailable, "gain: the device has no such setting"};
  }

 private:
  void FillFrame(RawFrame* frame) {
    pixels_.resize(FakeHost::kWidth * FakeHost::kHeight);
    for (size_t i = 0; i < pixels_.size(); ++i) pixels_[i] = static_cast<uint16_t>(500 + i);
    RawImage& depth = frame->depth.emplace();
    depth.width = FakeHost::kWidth;
    depth.height = FakeHost::kHeight;
    depth.stride_bytes = 2 * FakeHost::kWidth;
    depth.data = std::as_bytes(std::span(pixels_));
    frame->index = ++host_.frame_index;
    depth.device_time_us = host_.details.is_recording ? host_.frame_index * FakeHost::kPeriodUs
                                                      : host_.now_us + host_.device_offset_us;
    if (host_.with_color) {
      rgb_.assign(3 * pixels_.size(), std::byte{9});
      frame->color = frame->depth;
      frame->color->layout = PixelLayout::kRgb8;
      frame->color->stride_bytes = 3 * FakeHost::kWidth;
      frame->color->data = rgb_;
    }
    if (host_.faults.empty()) return;
    switch (host_.faults.front()) {
      case FakeHost::Fault::kNone:
      case FakeHost::Fault::kMarked:
        break;
      case FakeHost::Fault::kShort:
        depth.data = depth.data.first(depth.data.size() / 2);
        break;
      case FakeHost::Fault::kWrongSize:
        depth.width *= 2;
        break;
      case FakeHost::Fault::kWrongStride:
        depth.stride_bytes += 2;
        break;
      case FakeHost::Fault::kNoData:
        depth.data = {};
        break;
    }
    host_.faults.pop_front();
  }

  FakeHost& host_;
  std::string uri_;
  std::string serial_;
  std::vector<uint16_t> pixels_;
  std::vector<std::byte> rgb_;
};

class FakeApi : public CameraDeviceApi {
 public:
  explicit FakeApi(FakeHost& host) : host_(host) {}

  [[nodiscard]] std::string name() const override { return "fake"; }
  [[nodiscard]] std::string search_hint() const override { return "plug one in"; }
  std::vector<DeviceListing> List() override {
    ++host_.num_lists;
    std::vector<DeviceListing> listing;
    for (const auto& [uri, device] : host_.devices)
      listing.push_back({uri, "fake", {}, {"id:fake-" + uri}});
    return listing;
  }
  Result<std::unique_ptr<CameraDevice>> Open(const std::string& uri) override {
    std::string serial;
    if (!host_.details.is_recording) {
      const auto found = host_.devices.find(uri);
      if (found == host_.devices.end()) return Error{ErrorCode::kNotFound, uri + " is gone"};
      if (found->second.refuses_to_open) {
        return Error{ErrorCode::kUnavailable, uri + " can't be opened: permission denied"};
      }
      serial = found->second.serial;
    }
    return std::unique_ptr<CameraDevice>(std::make_unique<FakeDevice>(host_, uri, serial));
  }
  bool WaitForDevice(std::chrono::milliseconds timeout) override {
    if (std::exchange(host_.pressed_by_event, false)) return true;
    host_.Pass(std::chrono::microseconds(timeout).count());
    return false;
  }
  int64_t MonotonicUs() override { return host_.now_us; }
  int64_t WallUs() override { return host_.now_us + host_.wall_offset_us; }
  void Sleep(std::chrono::microseconds duration) override { host_.Pass(duration.count()); }

 private:
  FakeHost& host_;
};

}  // namespace vantage
