#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/v4l2/frame_converter.h"
#include "drivers/v4l2/paired_color.h"
#include "drivers/v4l2/v4l2_options.h"
#include "drivers/v4l2/v4l2_stream.h"

namespace vantage {

/// CameraDevice on a node of video4linux, and a second one for color beside its depth where the
/// options name one.
class V4l2Device : public CameraDevice {
 public:
  /// @param serial of its USB device, empty if it has none.
  /// @param color_paths nodes that options.color_device may mean; the first that has color is it.
  /// @param on_start called when it streams.
  /// Errors: as of DisparityModel::Validate() and V4l2Stream::Open().
  static Result<std::unique_ptr<CameraDevice>> Open(const std::string& path,
                                                    const std::string& serial,
                                                    const std::vector<std::string>& color_paths,
                                                    const V4l2Options& options,
                                                    const std::function<void()>& on_start);

  [[nodiscard]] std::string serial() const override { return serial_; }
  Result<StreamDetails> Start(const StreamRequest& request) override;
  ReadResult Read(std::chrono::milliseconds timeout, RawFrame* frame) override;
  /// Settings are those of the first node; of the color node those that the first lacks.
  Result<void> SetExposure(int exposure_us) override;
  Result<void> SetGain(int gain) override;
  Result<void> SetControl(const std::string& name, int64_t value) override;

 private:
  V4l2Device(const std::string& path,
             const std::string& serial,
             const std::vector<std::string>& color_paths,
             const V4l2Options& options,
             const std::function<void()>& on_start,
             std::unique_ptr<V4l2Stream> stream)
      : path_(path),
        serial_(serial),
        color_paths_(color_paths),
        options_(options),
        on_start_(on_start),
        stream_(std::move(stream)) {}

  Result<void> StartColor(const StreamRequest& request);
  [[nodiscard]] StreamDetails Details(const StreamRequest& request) const;
  template <class Set>
  Result<void> SetOnEither(const Set& set);

  std::string path_;
  std::string serial_;
  std::vector<std::string> color_paths_;
  V4l2Options options_;
  std::function<void()> on_start_;
  std::unique_ptr<V4l2Stream> stream_;
  std::optional<FrameConverter> converter_;
  std::unique_ptr<PairedColor> color_;  // Null: none.
  int num_errors_ = 0;                  // One after the other.
};

}  // namespace vantage
