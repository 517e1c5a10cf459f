#include "tools/log/log_import.h"

#include <cmath>
#include <memory>
#include <vector>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "common/time_range.h"
#include "tools/support/png_image.h"
#include "vantage/log_header_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kPoseStep = 10'000;  // us, 100 Hz
constexpr int kPosesBefore = 40;       // and as many after
constexpr const char* kHeaderChannel = "LOG_HEADER";

Result<void> WriteHeader(const LogImportParameters& parameters, EventLogWriter& writer) {
  const log_header_t header = MakeLogHeader(parameters.setup, parameters.start_utime);
  return writer.Write(header.utime, kHeaderChannel, Encode(header));
}

// Millimetres as the wire has them; what is farther than it can tell is no measurement.
std::vector<uint16_t> ToMillimetres(const std::vector<uint16_t>& values, double scale) {
  std::vector<uint16_t> millimetres(values.size(), 0);
  for (size_t i = 0; i < values.size(); ++i) {
    const double value = std::round(scale * values[i]);
    if (value >= 1.0 && value <= 65535.0) millimetres[i] = static_cast<uint16_t>(value);
  }
  return millimetres;
}

// One view's events, in the order of their times.
class ViewWriter {
 public:
  ViewWriter(const LogImportParameters& parameters, EventLogWriter& writer)
      : channel_("CAMERA_" + parameters.camera),
        name_(parameters.camera),
        compression_(parameters.compression),
        writer_(writer) {}

  Result<void> Write(const RecordedView& view, const Gray16Image& depth, int64_t utime) {
    CameraModel camera = view.camera;
    camera.width = depth.width;
    camera.height = depth.height;
    const CameraIdentity identity{.name = name_,
                                  .serial = "",
                                  .frame = name_ + "_depth",
                                  .registered = false,
                                  .calibration_id = "recorded"};
    const int64_t start = utime - kPosesBefore * kPoseStep;
    Result<void> written = writer_.Write(
        start, channel_ + "_INFO", Encode(CameraToMessage(camera, identity, start, seq_)));
    for (int i = -kPosesBefore; written && i <= kPosesBefore; ++i) {
      const int64_t at = utime + i * kPoseStep;
      written =
          writer_.Write(at, channel_ + "_TO_WORLD", Encode(PoseToMessage(view.T_world_camera, at)));
      if (written && i == 0) written = WriteImage(view, depth, utime);
    }
    ++seq_;
    return written;
  }

 private:
  Result<void> WriteImage(const RecordedView& view, const Gray16Image& depth, int64_t utime) {
    const images_t images = DepthToMessage(depth.width,
                                           depth.height,
                                           ToMillimetres(depth.gray, view.depth_scale),
                                           utime,
                                           seq_,
                                           "",
                                           compression_);
    return writer_.Write(utime, channel_, Encode(images));
  }

  std::string channel_;
  std::string name_;
  DepthCompression compression_;
  EventLogWriter& writer_;
  int64_t seq_ = 0;
};

}  // namespace

Result<void> LogImportParameters::Validate() const {
  constexpr size_t kLongest = 40;
  const bool letters =
      camera.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_") ==
      std::string::npos;
  if (camera.empty() || camera.size() > kLongest || !letters) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format(
            "camera name \"%.80s\", expected 1 to %zu of A-Z a-z 0-9 _", camera.c_str(), kLongest)};
  }
  if (!(view_interval >= 0.9 && view_interval <= 3600.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("view interval %g s, expected 0.9 to 3600 s", view_interval)};
  }
  if (!IsPlausibleUtime(start_utime)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("start at %jd us since the epoch, expected 0 to %jd",
                        intmax_t{start_utime},
                        intmax_t{kLatestUtime})};
  }
  return {};
}

Result<LogImportSummary> ImportViews(std::span<const RecordedView> views,
                                     const LogImportParameters& parameters,
                                     const std::filesystem::path& log) {
  if (Result<void> fits = parameters.Validate(); !fits) return fits.error();
  if (views.empty()) return Error{ErrorCode::kInvalidArgument, "no views to import"};
  Result<std::unique_ptr<EventLogWriter>> writer = EventLogWriter::Create(log);
  if (!writer) return writer.error();
  if (Result<void> written = WriteHeader(parameters, **writer); !written) return written.error();
  const auto interval = static_cast<int64_t>(std::llround(1e6 * parameters.view_interval));
  LogImportSummary summary;
  ViewWriter view_writer(parameters, **writer);
  for (const RecordedView& view : views) {
    const Result<Gray16Image> depth = ReadPng16(view.depth_file);
    if (!depth) return depth.error();
    if (depth->width > kMaxImageSide || depth->height > kMaxImageSide) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("%s has %d x %d px, expected sides of at most %d px, as on the bus",
                          view.depth_file.c_str(),
                          depth->width,
                          depth->height,
                          kMaxImageSide)};
    }
    if (summary.num_views == 0) {
      summary.width = depth->width;
      summary.height = depth->height;
    }
    if (depth->width != summary.width || depth->height != summary.height) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("%s has %d x %d px, expected %d x %d px as in the first view",
                          view.depth_file.c_str(),
                          depth->width,
                          depth->height,
                          summary.width,
                          summary.height)};
    }
    const int64_t utime = parameters.start_utime + (summary.num_views + 1) * interval;
    if (Result<void> written = view_writer.Write(view, *depth, utime); !written) {
      return written.error();
    }
    ++summary.num_views;
  }
  summary.num_events = (*writer)->num_events();
  if (Result<void> closed = (*writer)->Close(); !closed) return closed.error();
  return summary;
}

}  // namespace vantage
