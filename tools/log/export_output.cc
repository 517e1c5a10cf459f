#include "tools/log/export_output.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "common/format.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

Error CantBeWritten(const fs::path& file, const std::string& why) {
  return {ErrorCode::kIo, Format("%s can't be written: %s", file.c_str(), why.c_str())};
}

// @param mode of fopen().
Result<void> WriteInto(const fs::path& file, const char* mode, std::string_view text) {
  std::FILE* stream = std::fopen(file.c_str(), mode);
  if (stream == nullptr) return CantBeWritten(file, std::strerror(errno));
  const bool written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  const int reason = errno;
  const bool closed = std::fclose(stream) == 0;
  if (written && closed) return {};
  return CantBeWritten(file, std::strerror(written ? errno : reason));
}

}  // namespace

Result<std::unique_ptr<ExportFolder>> ExportFolder::Create(const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::absolute(folder).lexically_normal();
  const fs::path place = whole.has_filename() ? whole : whole.parent_path();
  if (fs::exists(place, error) && !(fs::is_directory(place, error) && fs::is_empty(place, error))) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("output %s exists, expected a new name or an empty folder", folder.c_str())};
  }
  const fs::path temporary = place.string() + Format(".partial-%d", getpid());
  if (!fs::create_directory(temporary, error)) return CantBeWritten(folder, error.message());
  return std::unique_ptr<ExportFolder>(new ExportFolder(place, temporary));
}

ExportFolder::~ExportFolder() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

Result<fs::path> ExportFolder::Sub(const std::string& name) const {
  const fs::path path = temporary_ / name;
  std::error_code error;
  fs::create_directories(path, error);
  if (error) return CantBeWritten(path, error.message());
  return path;
}

Result<void> ExportFolder::Publish() {
  std::error_code error;
  fs::rename(temporary_, folder_, error);  // Also over an empty folder.
  if (error) return CantBeWritten(folder_, error.message());
  temporary_.clear();
  return {};
}

std::string FileNameOf(std::string_view channel) {
  std::string name;
  for (const char c : channel) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '_' || c == '-' || (c == '.' && !name.empty());
    if (plain) {
      name += c;
    } else {
      name += Format("%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
    }
  }
  return name;
}

Result<void> AppendToFile(const fs::path& file, std::string_view text) {
  return WriteInto(file, "abe", text);
}

Result<void> ReplaceStart(const fs::path& file, std::string_view text) {
  return WriteInto(file, "r+be", text);
}

}  // namespace vantage
