#include "tools/evaluate/method_cache.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "tools/evaluate/detection_text.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = size_t{1} << 30U;  // Bytes; 100,000 sequences have half of it.
constexpr size_t kMaxViews = 100'000;

uint64_t HashNumbers(std::span<const double> numbers, uint64_t start) {
  uint64_t hash = start;
  for (const double number : numbers) {
    std::array<char, sizeof(double)> bytes{};
    std::memcpy(bytes.data(), &number, bytes.size());
    hash = Fnv1a({bytes.data(), bytes.size()}, hash);
  }
  return hash;
}

// All that an outcome depends on beside the program and the method.
uint64_t HashOf(const EvaluatedSequence& evaluated, uint64_t seed) {
  std::string text;
  AppendSequenceText(*evaluated.sequence, &text);
  uint64_t hash = Fnv1a(text);
  const auto& [kind, elements, axis, flips] = *evaluated.symmetry;
  hash = Fnv1a(Format("%d %d %ju", static_cast<int>(kind), flips ? 1 : 0, uintmax_t{seed}), hash);
  hash = HashNumbers({axis.data(), 3}, hash);
  for (const Eigen::Quaterniond& q : elements) hash = HashNumbers({q.coeffs().data(), 4}, hash);
  return hash;
}

void AppendNumber(double value, std::string* text) {
  std::array<char, 32> digits{};
  *text += ' ';
  text->append(digits.data(),
               std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

std::string Checksum(std::string_view content) {
  return Format(" %016jx", static_cast<uintmax_t>(Fnv1a(content)));
}

// hash, seconds per view, then both errors of each view; checksum.
std::string LineOf(uint64_t hash, const SequenceOutcome& outcome) {
  std::string line = Format("%016jx", static_cast<uintmax_t>(hash));
  AppendNumber(outcome.seconds_per_view, &line);
  for (size_t i = 0; i < outcome.error_deg.size(); ++i) {
    AppendNumber(outcome.error_deg[i], &line);
    AppendNumber(outcome.symmetric_deg[i], &line);
  }
  return line + Checksum(line) + "\n";
}

std::optional<std::pair<uint64_t, SequenceOutcome>> ParseLine(std::string_view line) {
  const size_t end = line.rfind(' ');
  if (end == std::string_view::npos || line.substr(end) != Checksum(line.substr(0, end))) return {};
  const char* position = line.data();
  const char* const last = line.data() + end;
  uint64_t hash = 0;
  const auto parsed = std::from_chars(position, last, hash, 16);
  if (parsed.ec != std::errc()) return {};
  position = parsed.ptr;
  std::vector<double> numbers;
  while (position != last) {
    if (*position != ' ' || numbers.size() > 2 * kMaxViews) return {};
    double number = 0.0;
    const auto [after, error] = std::from_chars(position + 1, last, number);
    if (error != std::errc()) return {};
    numbers.push_back(number);
    position = after;
  }
  if (numbers.size() % 2 != 1) return {};
  SequenceOutcome outcome;
  outcome.seconds_per_view = numbers[0];
  for (size_t i = 1; i < numbers.size(); i += 2) {
    outcome.error_deg.push_back(numbers[i]);
    outcome.symmetric_deg.push_back(numbers[i + 1]);
  }
  return std::pair(hash, std::move(outcome));
}

// One call of the system a line, so that lines of several processes don't mix.
bool Append(int descriptor, std::string_view text) {
  ssize_t count = -1;
  do {
    count = ::write(descriptor, text.data(), text.size());
  } while (count < 0 && errno == EINTR);
  return count == static_cast<ssize_t>(text.size());
}

}  // namespace

Result<uint64_t> HashOfThisProgram() {
  const Result<std::string> bytes =
      ReadFileBytes(std::filesystem::path("/proc/self/exe"), size_t{1} << 31U);
  if (!bytes) return bytes.error();
  return Fnv1a(*bytes);
}

Result<std::unique_ptr<MethodCache>> MethodCache::Create(const std::filesystem::path& folder,
                                                         uint64_t program_hash) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  return std::unique_ptr<MethodCache>(new MethodCache(folder, program_hash));
}

MethodCache::MethodCache(std::filesystem::path folder, uint64_t program_hash)
    : folder_(std::move(folder)), program_hash_(program_hash) {}

MethodCache::~MethodCache() {
  for (const auto& [name, file] : files_) {
    if (file.descriptor >= 0) ::close(file.descriptor);
  }
}

std::optional<SequenceOutcome> MethodCache::Find(const MethodInfo& method,
                                                 const EvaluatedSequence& evaluated,
                                                 uint64_t seed) {
  const uint64_t hash = HashOf(evaluated, seed);
  const std::lock_guard lock(mutex_);
  const File& file = FileOf(method);
  const auto found = file.outcomes.find(hash);
  if (found == file.outcomes.end()) return {};
  if (found->second.error_deg.size() != evaluated.sequence->views.size()) return {};
  ++num_found_;
  return found->second;
}

void MethodCache::Keep(const MethodInfo& method,
                       const EvaluatedSequence& evaluated,
                       uint64_t seed,
                       const SequenceOutcome& outcome) {
  const uint64_t hash = HashOf(evaluated, seed);
  const std::string line = LineOf(hash, outcome);
  const std::lock_guard lock(mutex_);
  File& file = FileOf(method);
  file.outcomes[hash] = outcome;
  if (file.descriptor >= 0 && !Append(file.descriptor, line)) Abandon(&file);
}

std::vector<std::string> MethodCache::Notes() {
  const std::lock_guard lock(mutex_);
  return notes_;
}

int64_t MethodCache::num_found() {
  const std::lock_guard lock(mutex_);
  return num_found_;
}

MethodCache::File& MethodCache::FileOf(const MethodInfo& method) {
  const auto [place, is_new] = files_.try_emplace(method.id + "\n" + method.parameters);
  File& file = place->second;
  if (!is_new) return file;
  const std::string content = Format("%016jx\n", uintmax_t{program_hash_}) + place->first;
  file.path = folder_ / Format("%s-%016jx.txt", method.id.c_str(), uintmax_t{Fnv1a(content)});
  Read(&file);
  Open(Format("# %s: %s\n", method.id.c_str(), method.parameters.c_str()), &file);
  return file;
}

void MethodCache::Read(File* file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file->path, ignored)) return;
  const Result<std::string> text = ReadFileBytes(file->path, kLargestFile);
  if (!text) {
    notes_.push_back(text.error().message + "; its outcomes are made again");
    return;
  }
  int64_t num_damaged = 0;
  for (size_t begin = 0; begin < text->size();) {
    const size_t end = std::min(text->find('\n', begin), text->size());
    const std::string_view line = std::string_view(*text).substr(begin, end - begin);
    begin = end + 1;
    if (line.empty() || line.front() == '#') continue;
    if (auto record = ParseLine(line)) {
      file->outcomes[record->first] = std::move(record->second);
    } else {
      ++num_damaged;
    }
  }
  file->is_sound = num_damaged == 0 && text->ends_with('\n');
  if (num_damaged > 0) {
    notes_.push_back(Format("%s: %jd lines are not whole; their outcomes are made again",
                            file->path.c_str(),
                            intmax_t{num_damaged}));
  }
}

// A file that is not sound is written anew with what is.
void MethodCache::Open(const std::string& head, File* file) {
  const int flags = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | (file->is_sound ? 0 : O_TRUNC);
  file->descriptor = ::open(file->path.c_str(), flags, 0644);
  std::string text;
  if (!file->is_sound) {
    text = head;
    for (const auto& [hash, outcome] : file->outcomes) text += LineOf(hash, outcome);
  }
  if (file->descriptor < 0 || !Append(file->descriptor, text)) Abandon(file);
}

void MethodCache::Abandon(File* file) {
  notes_.push_back(Format(
      "%s can't be written: %s; outcomes are not kept", file->path.c_str(), std::strerror(errno)));
  if (file->descriptor >= 0) ::close(file->descriptor);
  file->descriptor = -1;
}

}  // namespace vantage
