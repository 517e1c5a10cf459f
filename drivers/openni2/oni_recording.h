#pragma once

#include <OpenNI.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "common/result.h"

namespace vantage {

/// Where an api's devices are recorded: each opening into a file of its own.
struct RecordTarget {
  std::filesystem::path file;                   ///< of the first opening; empty: none is recorded
  int64_t min_free_bytes = int64_t{256} << 20;  ///< on its disk; with less a recording ends
  int num_files = 0;                            ///< that were begun

  /// Errors: the file exists, its folder doesn't, or it has no ending .oni.
  [[nodiscard]] Result<void> Validate() const;
  /// FILE.oni, then FILE-2.oni, FILE-3.oni ..., leaving out what exists.
  [[nodiscard]] std::filesystem::path NextFile();
};

/// One .oni file being written by OpenNI2's recorder: depth without loss, color as it came. The
/// recorder stamps the first image of each stream 0, so that both must begin with the same pair.
/// It also keeps a core busy (2.2.0.33 looks for work without pause), so its thread runs at a low
/// priority. Lives shorter than the streams.
class OniRecording {
 public:
  /// Attaches to the streams; nothing is recorded yet. Errors: the file can't be written.
  static Result<std::unique_ptr<OniRecording>> Open(const RecordTarget& target,
                                                    const std::filesystem::path& file,
                                                    openni::VideoStream& depth,
                                                    openni::VideoStream& color);
  /// Ends it; a file into which nothing was recorded is removed.
  ~OniRecording();
  OniRecording(const OniRecording&) = delete;
  OniRecording& operator=(const OniRecording&) = delete;

  /// Records all images from now on. False: it can't be told whether it has begun.
  bool Begin();
  [[nodiscard]] bool has_begun() const { return has_begun_; }
  /// Why it has to end, in one sentence; empty: it does not. To be asked once an image; looks now
  /// and then.
  std::string Trouble();
  /// What was recorded so far is worth nothing.
  void Discard() { has_begun_ = false; }

 private:
  OniRecording(std::filesystem::path file, int64_t min_free_bytes)
      : file_(std::move(file)), min_free_bytes_(min_free_bytes) {}

  std::filesystem::path file_;
  int64_t min_free_bytes_;
  openni::Recorder recorder_;
  bool has_begun_ = false;
  int num_images_ = 0;
};

}  // namespace vantage
