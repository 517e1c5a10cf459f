#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/result.h"

namespace vantage {

/// A folder that an export fills under a temporary name beside the wanted one, which it takes only
/// when it is complete.
class ExportFolder {
 public:
  /// Errors: something is there that is no empty folder, or the system refuses.
  static Result<std::unique_ptr<ExportFolder>> Create(const std::filesystem::path& folder);
  /// Without Publish() nothing is left behind.
  ~ExportFolder();
  ExportFolder(const ExportFolder&) = delete;
  ExportFolder& operator=(const ExportFolder&) = delete;

  /// Where to write meanwhile.
  [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }
  /// A folder in it, made if it is not there. Errors: the system refuses.
  Result<std::filesystem::path> Sub(const std::string& name) const;
  /// Errors: the system refuses.
  Result<void> Publish();

 private:
  ExportFolder(std::filesystem::path folder, std::filesystem::path temporary)
      : folder_(std::move(folder)), temporary_(std::move(temporary)) {}

  std::filesystem::path folder_;
  std::filesystem::path temporary_;
};

/// A channel's name as a file's: other characters than letters, digits, '_', '-' and inner '.'
/// become %XX.
std::string FileNameOf(std::string_view channel);

/// Adds a text to a file's end, making it where it is not. Errors: the system refuses.
Result<void> AppendToFile(const std::filesystem::path& file, std::string_view text);
/// Writes a text over a file's start. Errors: the system refuses.
Result<void> ReplaceStart(const std::filesystem::path& file, std::string_view text);

}  // namespace vantage
