#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "common/result.h"
#include "tools/support/png_image.h"

namespace vantage {

/// Frames to a video, by ffmpeg: .mp4 (H.264), .webm (VP9) or .gif, by the file's name.
class VideoWriter {
 public:
  /// Errors: another kind of file; ffmpeg is not installed; the folder can't be written.
  static Result<std::unique_ptr<VideoWriter>> Create(const std::filesystem::path& file,
                                                     int width,
                                                     int height,
                                                     double fps);
  /// Without Close() nothing is left behind.
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Errors: another size than at first; ffmpeg ended.
  Result<void> Write(const RgbImage& frame);
  /// Moves the video to its name. Errors: ffmpeg failed, with its last words.
  Result<void> Close();

 private:
  VideoWriter(std::filesystem::path file, int width, int height)
      : file_(std::move(file)), width_(width), height_(height) {}
  [[nodiscard]] std::filesystem::path Temporary() const;
  [[nodiscard]] std::filesystem::path Words() const;
  [[nodiscard]] Error Failure() const;

  std::filesystem::path file_;
  int width_;
  int height_;
  pid_t process_ = -1;
  std::FILE* pipe_ = nullptr;
};

}  // namespace vantage
