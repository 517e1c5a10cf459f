#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace vantage {

/// A file that is added to record by record and read anew by the next run: what is written is there
/// whole or, of a process that is killed, cut short at the end. It is locked while it is open.
class GrowingFile {
 public:
  /// Makes the file if it isn't there. Errors: the system refuses, another process has it open.
  static Result<GrowingFile> Open(const std::filesystem::path& file);
  ~GrowingFile();
  GrowingFile(GrowingFile&& other) noexcept;
  GrowingFile& operator=(GrowingFile&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// All of it. Errors: the system refuses, it is no regular file or has more than 2 GiB.
  Result<std::string> Read();
  /// Errors: the system refuses; the file is then as before.
  Result<void> Append(std::string_view text);
  /// Leaves the first `size` bytes. Errors: the system refuses.
  Result<void> CutTo(size_t size);
  /// Removes the file. Errors: the system refuses.
  Result<void> Remove();

 private:
  GrowingFile(std::filesystem::path path, int descriptor);

  std::filesystem::path path_;
  int descriptor_;
  size_t size_ = 0;  // Bytes of the file.
};

/// Number of the line, from 1, that a position is in.
std::ptrdiff_t LineAt(std::string_view text, size_t position);
/// That line, of it at most 80 characters.
std::string LineAround(std::string_view text, size_t position);

}  // namespace vantage
