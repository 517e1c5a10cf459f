#include "tools/evaluate/detection_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "tools/evaluate/detection_text.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = size_t{1} << 31U;  // Bytes; 100,000 sequences have a tenth of it.

std::string Header(const DetectionFileContent& content) {
  return "vantage detections\n" + content.key + "sequences\n";
}

// Number of the line, from 1, that a position is in.
std::ptrdiff_t LineAt(std::string_view text, size_t position) {
  return 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(position), '\n');
}

std::string LineAround(std::string_view text, size_t position) {
  constexpr size_t kLongest = 80;
  const size_t before = text.substr(0, position).rfind('\n');
  const size_t begin = before == std::string_view::npos ? 0 : before + 1;
  return std::string(text.substr(begin, std::min(kLongest, text.find('\n', begin) - begin)));
}

Error SystemError(const std::filesystem::path& file, const char* what) {
  return {ErrorCode::kIo, Format("%s can't be %s: %s", file.c_str(), what, std::strerror(errno))};
}

Result<std::string> ReadAll(int descriptor, const std::filesystem::path& file) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return SystemError(file, "read");
  if (!S_ISREG(status.st_mode) || static_cast<size_t>(status.st_size) > kLargestFile) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s has %jd bytes, expected a regular file of at most %zu",
                        file.c_str(),
                        static_cast<intmax_t>(status.st_size),
                        kLargestFile)};
  }
  std::string text(static_cast<size_t>(status.st_size), '\0');
  size_t done = 0;
  while (done < text.size()) {
    const ssize_t count =
        ::pread(descriptor, text.data() + done, text.size() - done, static_cast<off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return SystemError(file, "read");
    if (count == 0) break;
    done += static_cast<size_t>(count);
  }
  text.resize(done);
  return text;
}

}  // namespace

std::string DetectionFileContent::FileName() const {
  return Format(
      "%s-%s-%016jx.txt", model_id.c_str(), Name(kind).c_str(), static_cast<uintmax_t>(Fnv1a(key)));
}

Result<DetectionCache> DetectionCache::Open(const std::filesystem::path& folder,
                                            const DetectionFileContent& content) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  const std::filesystem::path file = folder / content.FileName();
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor < 0) return SystemError(file, "opened");
  DetectionCache cache(file, content, descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::kUnavailable,
                 Format("%s is in use by another run, expected to have it alone", file.c_str())};
  }
  if (Result<void> loaded = cache.Load(); !loaded) return loaded.error();
  return cache;
}

DetectionCache::DetectionCache(std::filesystem::path file,
                               DetectionFileContent content,
                               int descriptor)
    : file_(std::move(file)), content_(std::move(content)), descriptor_(descriptor) {}

DetectionCache::DetectionCache(DetectionCache&& other) noexcept
    : file_(std::move(other.file_)),
      content_(std::move(other.content_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_),
      sequences_(std::move(other.sequences_)),
      note_(std::move(other.note_)) {}

DetectionCache::~DetectionCache() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> DetectionCache::Load() {
  const Result<std::string> bytes = ReadAll(descriptor_, file_);
  if (!bytes) return bytes.error();
  const std::string_view text = *bytes;
  size_ = text.size();
  const Result<size_t> header_end = CheckHeader(text);
  if (!header_end) return header_end.error();
  for (size_t position = *header_end; position < text.size();) {
    const SequenceText first = FirstSequenceText(text.substr(position));
    const bool is_last = position + first.record.size() == text.size();
    if (first.is_whole) {
      if (Result<void> taken = Take(text, position); !taken) return taken;
    } else if (is_last) {
      note_ = Format("%s, line %td: the last record is not whole and is made again",
                     file_.c_str(),
                     LineAt(text, position));
      return CutTo(position);
    } else {
      return Error{ErrorCode::kCorrupt,
                   Format("%s, line %td: the record from here does not agree with its checksum, "
                          "expected it whole; remove the file to make it again",
                          file_.c_str(),
                          LineAt(text, position))};
    }
    position += first.record.size();
  }
  return {};
}

// Where the header ends. It is written when all that is there is a part of it.
Result<size_t> DetectionCache::CheckHeader(std::string_view text) {
  const std::string header = Header(content_);
  if (text.substr(0, header.size()) == header) return header.size();
  const auto [differ, unused] =
      std::mismatch(text.begin(), text.end(), header.begin(), header.end());
  if (differ == text.end()) {
    if (!text.empty()) note_ = Format("%s: its head is not whole and is made again", file_.c_str());
    if (Result<void> cut = CutTo(0); !cut) return cut.error();
    if (Result<void> written = Write(header); !written) return written.error();
    return header.size();
  }
  const auto position = static_cast<size_t>(differ - text.begin());
  return Error{ErrorCode::kCorrupt,
               Format("%s, line %td: \"%s\", expected \"%s\"; remove the file to make it again",
                      file_.c_str(),
                      LineAt(text, position),
                      LineAround(text, position).c_str(),
                      LineAround(header, position).c_str())};
}

// Takes the whole record at a position.
Result<void> DetectionCache::Take(std::string_view text, size_t position) {
  size_t line = 0;
  Result<DetectionSequence> sequence =
      ParseSequenceText(FirstSequenceText(text.substr(position)).record, &line);
  std::string wrong;
  if (!sequence) {
    wrong = sequence.error().message;
  } else if (static_cast<size_t>(sequence->index) != sequences_.size()) {
    wrong = Format("is of sequence %d, expected %zu", sequence->index, sequences_.size());
  } else if (sequence->views.size() != static_cast<size_t>(content_.num_views)) {
    wrong = Format("begins %zu views, expected %d", sequence->views.size(), content_.num_views);
  }
  if (!wrong.empty()) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s, line %td %s; remove the file to make it again",
                        file_.c_str(),
                        LineAt(text, position) + static_cast<std::ptrdiff_t>(line),
                        wrong.c_str())};
  }
  sequence->model_id = content_.model_id;
  for (DetectedView& view : sequence->views) {
    for (Detection& detection : view.detections) detection.model_id = content_.model_id;
  }
  sequences_.push_back(std::move(sequence).value());
  return {};
}

Result<void> DetectionCache::Append(DetectionSequence sequence) {
  VANTAGE_CHECK(static_cast<size_t>(sequence.index) == sequences_.size() &&
                    sequence.views.size() == static_cast<size_t>(content_.num_views),
                Format("sequence %d with %zu views", sequence.index, sequence.views.size()));
  std::string text;
  AppendSequenceText(sequence, &text);
  if (Result<void> written = Write(text); !written) return written;
  sequences_.push_back(std::move(sequence));
  return {};
}

Result<void> DetectionCache::Write(std::string_view text) {
  const size_t before = size_;
  for (size_t done = 0; done < text.size();) {
    const ssize_t count = ::write(descriptor_, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const Error error = SystemError(file_, "written");
      static_cast<void>(CutTo(before).ok());  // What stays is cut off by the next Open.
      return error;
    }
    done += static_cast<size_t>(count);
  }
  size_ = before + text.size();
  return {};
}

Result<void> DetectionCache::CutTo(size_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) return SystemError(file_, "cut");
  size_ = size;
  return {};
}

}  // namespace vantage
