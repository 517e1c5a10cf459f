#include "tests/bench/large_log.h"

#include <memory>
#include <vector>

#include "bus/event_log_writer.h"
#include "bus/image_conversion.h"
#include "bus/log_bus.h"
#include "bus/message_check.h"
#include "common/rng.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/log_header_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"
#include "vantage/orientation_histogram_t.hpp"
#include "vantage/process_status_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

constexpr int64_t kStart = 1'700'000'000'000'000;  // us
constexpr int64_t kStep = 10'000;                  // us
constexpr size_t kImageBytes = 22'000;
constexpr int kCells = 2'500;

// What is sent in one step of 10 ms; counts the bytes of the log.
class RecordedRun {
 public:
  explicit RecordedRun(EventLogWriter& writer) : writer_(writer) {
    image_.width = 640;
    image_.height = 480;
    image_.row_stride = 1280;
    image_.pixelformat = image_t::PIXEL_FORMAT_INVALID;
    Rng rng(1);
    for (size_t i = 0; i < kImageBytes; ++i) {
      image_.data.push_back(static_cast<uint8_t>(rng.Below(256)));
    }
    histogram_.k = 32;
    histogram_.num_cells = kCells;
    histogram_.cell.assign(kCells, 7);
    histogram_.weight.assign(kCells, 0.5F);
  }

  [[nodiscard]] int64_t num_bytes() const { return num_bytes_; }

  Result<void> WriteHeader() {
    log_header_t header{};
    header.utime = kStart;
    header.version = VANTAGE_VERSION;
    FillSchemas(&header);
    return Write("LOG_HEADER", header);
  }

  Result<void> WriteStep(int64_t step) {
    utime_ = kStart + step * kStep;
    rigid_transform_t pose{};
    pose.utime = utime_;
    pose.quat[0] = 1.0;
    if (Result<void> written = Write("CAMERA_XTION_TO_WORLD", pose); !written) return written;
    if (step % 10 == 0) {
      if (Result<void> written = WriteImage(step / 10); !written) return written;
      arm_status_t arm{};
      arm.utime = utime_;
      arm.seq = step / 10;
      if (Result<void> written = Write("ARM_STATUS", arm); !written) return written;
    }
    if (step % 100 == 50) return WriteEstimates(step / 100);
    return {};
  }

 private:
  Result<void> WriteImage(int64_t seq) {
    image_t image = image_;
    image.utime = utime_;
    AppendIdentity(seq, "B0001", &image);
    images_t images{};
    images.utime = utime_;
    AppendImage(images_t::DEPTH_MM_VDC, std::move(image), &images);
    return Write("CAMERA_XTION", images);
  }

  Result<void> WriteEstimates(int64_t seq) {
    object_estimates_v3_t objects{};
    objects.utime = utime_;
    objects.seq = seq;
    histogram_.utime = utime_;
    histogram_.seq = seq;
    process_status_t status{};
    status.utime = utime_;
    status.seq = seq;
    status.name = "fusion";
    Result<void> written = Write("OBJECTS", objects);
    if (written) written = Write("ORIENTATION_HISTOGRAM", histogram_);
    if (written) written = Write("PROCESS_STATUS", status);
    return written;
  }

  template <class Message>
  Result<void> Write(const char* channel, const Message& message) {
    const std::vector<std::byte> bytes = Encode(message);
    num_bytes_ += static_cast<int64_t>(bytes.size());
    return writer_.Write(utime_, channel, bytes);
  }

  EventLogWriter& writer_;
  image_t image_{};
  orientation_histogram_t histogram_{};
  int64_t utime_ = kStart;
  int64_t num_bytes_ = 0;
};

}  // namespace

Result<void> WriteLargeLog(const std::filesystem::path& file, int64_t num_bytes) {
  Result<std::unique_ptr<EventLogWriter>> writer = EventLogWriter::Create(file);
  if (!writer) return writer.error();
  RecordedRun run(**writer);
  if (Result<void> written = run.WriteHeader(); !written) return written;
  for (int64_t step = 0; run.num_bytes() < num_bytes; ++step) {
    if (Result<void> written = run.WriteStep(step); !written) return written;
  }
  return (*writer)->Close();
}

}  // namespace vantage
