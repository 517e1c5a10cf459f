#include "tools/support/growing_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = size_t{1} << 31U;  // Bytes; 100,000 records have a fourth of it.

Error CantBe(const std::filesystem::path& file, const char* what) {
  return {ErrorCode::kIo, Format("%s can't be %s: %s", file.c_str(), what, std::strerror(errno))};
}

}  // namespace

Result<GrowingFile> GrowingFile::Open(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor < 0) return CantBe(file, "opened");
  GrowingFile opened(file, descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::kUnavailable,
                 Format("%s is in use by another run, expected to have it alone", file.c_str())};
  }
  return opened;
}

GrowingFile::GrowingFile(std::filesystem::path path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {}

GrowingFile::GrowingFile(GrowingFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

GrowingFile::~GrowingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<std::string> GrowingFile::Read() {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) return CantBe(path_, "read");
  if (!S_ISREG(status.st_mode) || static_cast<size_t>(status.st_size) > kLargestFile) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s has %jd bytes, expected a regular file of at most %zu",
                        path_.c_str(),
                        static_cast<intmax_t>(status.st_size),
                        kLargestFile)};
  }
  std::string text(static_cast<size_t>(status.st_size), '\0');
  size_t done = 0;
  while (done < text.size()) {
    const ssize_t count =
        ::pread(descriptor_, text.data() + done, text.size() - done, static_cast<off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return CantBe(path_, "read");
    if (count == 0) break;
    done += static_cast<size_t>(count);
  }
  text.resize(done);
  size_ = done;
  return text;
}

Result<void> GrowingFile::Append(std::string_view text) {
  const size_t before = size_;
  for (size_t done = 0; done < text.size();) {
    const ssize_t count = ::write(descriptor_, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const Error error = CantBe(path_, "written");
      static_cast<void>(CutTo(before).ok());  // What stays is cut off by the next reader.
      return error;
    }
    done += static_cast<size_t>(count);
  }
  size_ = before + text.size();
  return {};
}

Result<void> GrowingFile::CutTo(size_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) return CantBe(path_, "cut");
  size_ = size;
  return {};
}

Result<void> GrowingFile::Remove() {
  if (::unlink(path_.c_str()) != 0) return CantBe(path_, "removed");
  return {};
}

std::ptrdiff_t LineAt(std::string_view text, size_t position) {
  return 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(position), '\n');
}

std::string LineAround(std::string_view text, size_t position) {
  constexpr size_t kLongest = 80;
  const size_t before = text.substr(0, position).rfind('\n');
  const size_t begin = before == std::string_view::npos ? 0 : before + 1;
  return std::string(text.substr(begin, std::min(kLongest, text.find('\n', begin) - begin)));
}

}  // namespace vantage
