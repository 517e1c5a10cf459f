#include "bus/event_log_writer.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "bus/channel_pattern.h"
#include "bus/event_log_format.h"
#include "common/format.h"

namespace vantage {
namespace {

Error Refused(const std::filesystem::path& file, const char* what) {
  return {ErrorCode::kIo,
          Format("log %s can't be %s: %s", file.c_str(), what, std::strerror(errno))};
}

}  // namespace

Result<std::unique_ptr<EventLogWriter>> EventLogWriter::Create(const std::filesystem::path& file) {
  const std::filesystem::path temporary = file.string() + Format(".partial-%d", getpid());
  std::FILE* stream = std::fopen(temporary.c_str(), "wbe");
  if (stream == nullptr) return Refused(file, "written");
  return std::unique_ptr<EventLogWriter>(new EventLogWriter(file, temporary, stream));
}

EventLogWriter::~EventLogWriter() {
  if (stream_ == nullptr) return;
  std::fclose(stream_);
  unlink(temporary_.c_str());
}

Result<void> EventLogWriter::Write(int64_t utime,
                                   std::string_view channel,
                                   std::span<const std::byte> data) {
  if (channel.empty() || channel.size() > kMaxChannelName) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("channel '%.*s' can't go into log %s, expected 1 to %zu characters",
                        static_cast<int>(std::min<size_t>(channel.size(), 80)),
                        channel.data(),
                        file_.c_str(),
                        kMaxChannelName)};
  }
  if (data.size() > static_cast<size_t>(EventHeader::kMaxDataBytes)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%zu bytes on %.*s can't go into log %s, expected %d at most",
                        data.size(),
                        static_cast<int>(channel.size()),
                        channel.data(),
                        file_.c_str(),
                        EventHeader::kMaxDataBytes)};
  }
  VANTAGE_CHECK(stream_ != nullptr, "a closed log is written to");
  const EventHeader header{.number = num_events_,
                           .utime = utime,
                           .channel_bytes = static_cast<int32_t>(channel.size()),
                           .data_bytes = static_cast<int32_t>(data.size())};
  std::array<std::byte, EventHeader::kBytes> bytes{};
  header.Store(bytes);
  const bool written =
      std::fwrite(bytes.data(), 1, bytes.size(), stream_) == bytes.size() &&
      std::fwrite(channel.data(), 1, channel.size(), stream_) == channel.size() &&
      (data.empty() || std::fwrite(data.data(), 1, data.size(), stream_) == data.size());
  if (!written) return Refused(file_, "written");
  ++num_events_;
  return {};
}

Result<void> EventLogWriter::Close() {
  VANTAGE_CHECK(stream_ != nullptr, "a closed log is closed again");
  const bool flushed = std::fflush(stream_) == 0;
  const int error = errno;
  const bool closed = std::fclose(std::exchange(stream_, nullptr)) == 0;
  if (flushed && closed && std::rename(temporary_.c_str(), file_.c_str()) == 0) return {};
  if (!flushed) errno = error;
  Error refused = Refused(file_, "completed");
  unlink(temporary_.c_str());
  return refused;
}

}  // namespace vantage
