#include "perception/model/file_bytes.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "common/format.h"

namespace vantage {

Result<std::string> ReadFileBytes(const std::filesystem::path& file, size_t largest) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    return Error{ErrorCode::kNotFound,
                 Format("%s: no such file, expected one to read", file.c_str())};
  }
  if (!std::filesystem::is_regular_file(status)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is not a file, expected a regular file", file.c_str())};
  }
  const uintmax_t size = std::filesystem::file_size(file, error);
  if (error) {
    return Error{ErrorCode::kIo, Format("%s: %s", file.c_str(), error.message().c_str())};
  }
  if (size > largest) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s has %ju bytes, expected at most %zu", file.c_str(), size, largest)};
  }
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<size_t>(size), '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be read: %s", file.c_str(), std::strerror(errno))};
  }
  return bytes;
}

Result<void> WriteFileBytes(const std::filesystem::path& file, std::string_view bytes) {
  errno = 0;
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) {
    const std::string reason = std::strerror(errno);
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    return Error{ErrorCode::kIo, Format("%s can't be written: %s", file.c_str(), reason.c_str())};
  }
  return {};
}

}  // namespace vantage
