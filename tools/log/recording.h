#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/log/log_setup.h"
#include "tools/log/recording_file.h"

namespace vantage {

struct RecordingOptions {
  std::filesystem::path file;    ///< or,
  std::filesystem::path folder;  ///< in which files are named after the time at which they start
  bool overwrite = false;
  /// A file that has as much is followed by another: FILE-000, FILE-001 and so on, or in the folder
  /// one of a later name. 0: no bound.
  int64_t split_bytes = 0;
  int64_t split_us = 0;                         ///< us; the same by time
  int64_t min_free_bytes = int64_t{256} << 20;  ///< with less left on the disk it ends
  LogSetup setup;
};

/// A recording in one or several files, each with LOG_HEADER first. What was written survives the
/// end of the process when Poll() was called after it.
class Recording {
 public:
  struct Part {
    std::filesystem::path file;
    int64_t num_events = 0;
    int64_t num_bytes = 0;
  };

  /// Makes the first file. @param utime us since the epoch, now.
  /// Errors: as RecordingFile::Create(), files of a split recording of this name are there, the
  /// folder is none, or the disk is full already.
  static Result<std::unique_ptr<Recording>> Start(const RecordingOptions& options, int64_t utime);

  /// Errors: as RecordingFile's, or the disk is full.
  Result<void> Write(int64_t utime, const std::string& channel, std::span<const std::byte> data);
  /// Gives to the system what waits, and looks how full the disk is. Errors: as Write().
  Result<void> Poll();
  /// Waits until the disk has everything. Errors: as Write().
  Result<void> Sync();

  /// All files, the one in work last.
  [[nodiscard]] std::vector<Part> Parts() const;
  [[nodiscard]] const std::filesystem::path& path() const { return file_->path(); }

 private:
  explicit Recording(const RecordingOptions& options) : options_(options) {}

  [[nodiscard]] std::filesystem::path NextPath(int64_t utime) const;
  Result<void> Begin(int64_t utime);
  [[nodiscard]] bool IsFull(int64_t utime, size_t more) const;
  [[nodiscard]] Result<void> CheckDisk(const std::filesystem::path& file) const;

  RecordingOptions options_;
  std::vector<Part> done_;
  std::unique_ptr<RecordingFile> file_;
  int64_t begin_utime_ = 0;  // Of file_.
};

}  // namespace vantage
