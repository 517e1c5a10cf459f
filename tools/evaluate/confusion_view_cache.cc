#include "tools/evaluate/confusion_view_cache.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <system_error>
#include <utility>

#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = size_t{1} << 30U;  // Bytes; ten million views.

void AppendNumber(double value, std::string* text) {
  std::array<char, 32> digits{};
  *text += ' ';
  text->append(digits.data(),
               std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

std::string Checksum(std::string_view content) {
  return Format(" %016jx", static_cast<uintmax_t>(Fnv1a(content)));
}

uint64_t HashOf(const SeenFrom& from) {
  std::string text = Format("%d %d", from.sequence, from.step);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      AppendNumber(from.T_world_camera(row, column), &text);
    }
  }
  return Fnv1a(text);
}

// hash, mse and the quaternion w x y z where something was found; checksum.
std::string LineOf(uint64_t hash, const SeenOrientation& seen) {
  std::string line = Format("%016jx", static_cast<uintmax_t>(hash));
  if (seen.q_world_object) {
    const Eigen::Quaterniond& q = *seen.q_world_object;
    for (const double value : {seen.mse, q.w(), q.x(), q.y(), q.z()}) AppendNumber(value, &line);
  }
  return line + Checksum(line) + "\n";
}

std::optional<std::pair<uint64_t, SeenOrientation>> ParseLine(std::string_view line) {
  const size_t end = line.rfind(' ');
  if (end == std::string_view::npos || line.substr(end) != Checksum(line.substr(0, end))) return {};
  const char* const last = line.data() + end;
  uint64_t hash = 0;
  auto [position, error] = std::from_chars(line.data(), last, hash, 16);
  if (error != std::errc()) return {};
  std::vector<double> numbers;
  while (position != last) {
    double number = 0.0;
    if (*position != ' ' || numbers.size() >= 5) return {};
    const auto parsed = std::from_chars(position + 1, last, number);
    if (parsed.ec != std::errc() || !std::isfinite(number)) return {};
    numbers.push_back(number);
    position = parsed.ptr;
  }
  SeenOrientation seen;
  if (numbers.empty()) return std::pair(hash, seen);
  if (numbers.size() != 5) return {};
  const Eigen::Quaterniond q(numbers[1], numbers[2], numbers[3], numbers[4]);
  if (!(std::abs(q.norm() - 1.0) < 1e-6)) return {};
  seen.mse = numbers[0];
  seen.q_world_object = q;
  return std::pair(hash, seen);
}

Error SystemError(const std::filesystem::path& file, const char* what) {
  return {ErrorCode::kIo, Format("%s can't be %s: %s", file.c_str(), what, std::strerror(errno))};
}

}  // namespace

Result<std::unique_ptr<ConfusionViewCache>> ConfusionViewCache::Open(
    const std::filesystem::path& folder, const std::string& name, const std::string& key) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  std::unique_ptr<ConfusionViewCache> cache(new ConfusionViewCache(
      folder / Format("%s-%016jx.txt", name.c_str(), static_cast<uintmax_t>(Fnv1a(key)))));
  const Result<void> loaded = cache->Load("vantage views\n" + key + "views\n");
  if (!loaded) return loaded.error();
  return cache;
}

ConfusionViewCache::~ConfusionViewCache() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

// A file that is not sound is written anew with what is.
Result<void> ConfusionViewCache::Load(const std::string& head) {
  std::error_code ignored;
  bool is_sound = false;
  if (std::filesystem::exists(file_, ignored)) {
    const Result<std::string> text = ReadFileBytes(file_, kLargestFile);
    if (!text) return text.error();
    if (text->starts_with(head)) {
      TakeLines(std::string_view(*text).substr(head.size()));
      is_sound = note_.empty() && text->ends_with('\n');
    } else if (!head.starts_with(*text)) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s is of another key than its name says; remove the file to make it "
                          "again",
                          file_.c_str())};
    }
  }
  const int flags = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | (is_sound ? 0 : O_TRUNC);
  descriptor_ = ::open(file_.c_str(), flags, 0644);
  if (descriptor_ < 0) return SystemError(file_, "opened");
  if (is_sound) return {};
  std::string text = head;
  for (const auto& [hash, seen] : seen_) text += LineOf(hash, seen);
  return Append(text);
}

void ConfusionViewCache::TakeLines(std::string_view lines) {
  int64_t num_damaged = 0;
  while (!lines.empty()) {
    const size_t end = std::min(lines.find('\n'), lines.size());
    if (const auto record = ParseLine(lines.substr(0, end))) {
      seen_[record->first] = record->second;
    } else {
      ++num_damaged;
    }
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
  if (num_damaged > 0) {
    note_ = Format("%s: %jd lines are not whole; their views are made again",
                   file_.c_str(),
                   intmax_t{num_damaged});
  }
}

std::optional<SeenOrientation> ConfusionViewCache::Find(const SeenFrom& from) {
  const uint64_t hash = HashOf(from);
  const std::lock_guard lock(mutex_);
  const auto found = seen_.find(hash);
  if (found == seen_.end()) return {};
  return found->second;
}

Result<void> ConfusionViewCache::Keep(const SeenFrom& from, const SeenOrientation& seen) {
  const uint64_t hash = HashOf(from);
  const std::lock_guard lock(mutex_);
  seen_[hash] = seen;
  return Append(LineOf(hash, seen));
}

// One call of the system a line, so that lines of several processes don't mix.
Result<void> ConfusionViewCache::Append(std::string_view text) const {
  ssize_t count = -1;
  do {
    count = ::write(descriptor_, text.data(), text.size());
  } while (count < 0 && errno == EINTR);
  if (count != static_cast<ssize_t>(text.size())) return SystemError(file_, "written");
  return {};
}

}  // namespace vantage
