#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// An LCM event log that is written while things happen: under its own name and only ever added to,
/// so that whoever opens it meanwhile, or after a crash, finds whole events and at most one that is
/// cut off at the end. It is locked while it is open.
class RecordingFile {
 public:
  /// Errors: it exists and `overwrite` is false, it is no regular file, another recording has it
  /// open, the system refuses.
  static Result<std::unique_ptr<RecordingFile>> Create(const std::filesystem::path& file,
                                                       bool overwrite);
  /// Writes what waits; what then fails can't be told.
  ~RecordingFile();
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;

  /// Adds an event for which Takes() is true, in memory until kFlushBytes wait. Errors: as Flush().
  Result<void> Write(int64_t utime, const std::string& channel, std::span<const std::byte> data);
  /// Gives what waits to the system: then the end of this process loses nothing of it. Errors: the
  /// system refuses, as when the disk is full; the file then ends with the last event that went in
  /// whole, and nothing more can be written.
  Result<void> Flush();
  /// Flush(), and waits until the disk has it. Errors: as there.
  Result<void> Sync();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] int64_t num_events() const { return num_events_; }
  [[nodiscard]] int64_t num_bytes() const;  ///< with what waits

  /// Whether logs take such an event.
  static bool Takes(const std::string& channel, size_t data_bytes);

  static constexpr size_t kFlushBytes = 1U << 20U;

 private:
  RecordingFile(std::filesystem::path path, int descriptor)
      : path_(std::move(path)), descriptor_(descriptor) {}
  Error CutAfterWhole(size_t written, int reason);

  std::filesystem::path path_;
  int descriptor_;
  int64_t num_written_ = 0;         // Bytes of whole events in the file.
  int64_t num_events_ = 0;          // Of these and of those that wait.
  std::vector<std::byte> buffer_;   // Events that wait.
  std::vector<size_t> event_ends_;  // In the buffer.
  bool failed_ = false;
};

}  // namespace vantage
