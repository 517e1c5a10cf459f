#include "tools/log/recording_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "bus/channel_pattern.h"
#include "bus/event_log.h"
#include "bus/event_log_format.h"
#include "common/format.h"

namespace vantage {
namespace {

Error Refused(const std::filesystem::path& file, int reason) {
  return {ErrorCode::kIo,
          Format("recording %s can't be written: %s", file.c_str(), std::strerror(reason))};
}

// The reason why an open file may not be recorded into; 0: it may.
Result<void> Claim(const std::filesystem::path& file, int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("recording %s is no regular file, expected one or a new name", file.c_str())};
  }
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return Error{
        ErrorCode::kUnavailable,
        Format("another recording writes to %s already, expected a file for each", file.c_str())};
  }
  if (ftruncate(descriptor, 0) != 0) return Refused(file, errno);
  return {};
}

}  // namespace

Result<std::unique_ptr<RecordingFile>> RecordingFile::Create(const std::filesystem::path& file,
                                                             bool overwrite) {
  // Not O_TRUNC: a file that another recording writes to must stay as it is.
  const int flags = O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK | (overwrite ? 0 : O_EXCL);
  const int descriptor = open(file.c_str(), flags, 0666);
  if (descriptor < 0 && errno == EEXIST) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("recording %s exists already, expected a new name or --force", file.c_str())};
  }
  if (descriptor < 0) return Refused(file, errno);
  if (Result<void> claimed = Claim(file, descriptor); !claimed) {
    close(descriptor);
    return claimed.error();
  }
  return std::unique_ptr<RecordingFile>(new RecordingFile(file, descriptor));
}

RecordingFile::~RecordingFile() {
  if (!failed_) (void)Flush();
  close(descriptor_);
}

Result<void> RecordingFile::Write(int64_t utime,
                                  const std::string& channel,
                                  std::span<const std::byte> data) {
  VANTAGE_CHECK(!failed_, "a recording that failed is written to");
  VANTAGE_CHECK(Takes(channel, data.size()), channel);
  const EventHeader header{.number = num_events_,
                           .utime = utime,
                           .channel_bytes = static_cast<int32_t>(channel.size()),
                           .data_bytes = static_cast<int32_t>(data.size())};
  std::array<std::byte, EventHeader::kBytes> bytes{};
  header.Store(bytes);
  const auto name = std::as_bytes(std::span(channel));
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  buffer_.insert(buffer_.end(), name.begin(), name.end());
  buffer_.insert(buffer_.end(), data.begin(), data.end());
  event_ends_.push_back(buffer_.size());
  ++num_events_;
  if (buffer_.size() >= kFlushBytes) return Flush();
  return {};
}

Result<void> RecordingFile::Flush() {
  VANTAGE_CHECK(!failed_, "a recording that failed is written to");
  size_t written = 0;
  while (written < buffer_.size()) {
    const ssize_t count = write(descriptor_, buffer_.data() + written, buffer_.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return CutAfterWhole(written, count < 0 ? errno : EIO);
    written += static_cast<size_t>(count);
  }
  num_written_ += static_cast<int64_t>(written);
  buffer_.clear();
  event_ends_.clear();
  return {};
}

Result<void> RecordingFile::Sync() {
  if (Result<void> flushed = Flush(); !flushed) return flushed;
  if (fdatasync(descriptor_) == 0) return {};
  failed_ = true;
  return Refused(path_, errno);
}

// After `written` bytes of the buffer the system refused the rest.
Error RecordingFile::CutAfterWhole(size_t written, int reason) {
  failed_ = true;
  const auto whole = std::upper_bound(event_ends_.begin(), event_ends_.end(), written);
  num_events_ -= event_ends_.end() - whole;
  if (whole != event_ends_.begin()) num_written_ += static_cast<int64_t>(*std::prev(whole));
  buffer_.clear();
  event_ends_.clear();
  Error refused = Refused(path_, reason);
  if (ftruncate(descriptor_, num_written_) != 0) {
    refused.message +=
        Format(", and the part of an event at its end can't be cut off: %s", std::strerror(errno));
  }
  return refused;
}

int64_t RecordingFile::num_bytes() const {
  return num_written_ + static_cast<int64_t>(buffer_.size());
}

bool RecordingFile::Takes(const std::string& channel, size_t data_bytes) {
  return !channel.empty() && channel.size() <= kMaxChannelName &&
         data_bytes <= static_cast<size_t>(EventLogReader::kMaxEventBytes);
}

}  // namespace vantage
