#include "tools/contingency/work_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "fusion/so3_grid.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = size_t{1} << 31U;  // Bytes; 100,000 directions have a fourth of it.
constexpr int kMostSteps = 722;                    // Of half a turn, and rounding.

void AppendText(const char* name, const std::string& lines, std::string* header) {
  *header += name;
  for (size_t begin = 0; begin < lines.size();) {
    const size_t end = std::min(lines.find('\n', begin), lines.size());
    *header += "\n  ";
    *header += lines.substr(begin, end - begin);
    begin = end + 1;
  }
  *header += '\n';
}

std::string Header(const ContingencyKey& key) {
  std::string header = "vantage contingency trials\n";
  header += "model " + key.model_id + "\nmesh " + key.mesh_hash + "\nestimator " + key.estimator;
  header += Format("\nseed %ju\ndirections %d\nrows of k %d\n",
                   static_cast<uintmax_t>(key.seed),
                   key.num_directions,
                   key.rows_k);
  AppendText("estimator parameters", key.estimator_parameters, &header);
  AppendText("sensor", key.sensor, &header);
  AppendText("stopping", key.stopping, &header);
  return header + "trials\n";
}

std::string WithChecksum(std::string line) {
  line += Format(" #%016jx\n", static_cast<uintmax_t>(Fnv1a(line)));
  return line;
}

// Numbers of a line, one after the other. After the first that is wrong there are none.
class Numbers {
 public:
  explicit Numbers(std::string_view text) : text_(text) {}

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool is_at_end() const { return text_.empty(); }

  /// 0 when it is not within the bounds.
  int32_t Next(int32_t lowest, int32_t highest) {
    int32_t value = 0;
    if (!text_.empty() && text_.front() == ' ') text_.remove_prefix(1);
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    ok_ = ok_ && error == std::errc() && value >= lowest && value <= highest;
    text_.remove_prefix(static_cast<size_t>(end - text_.data()));
    if (!ok_) text_ = {};
    return ok_ ? value : 0;
  }

 private:
  std::string_view text_;
  bool ok_ = true;
};

constexpr int32_t kMost = std::numeric_limits<int32_t>::max();

template <class Trials>
bool ReadCounts(Numbers* numbers, Trials* trials) {
  trials->trials = numbers->Next(1, kMost);
  trials->missed = numbers->Next(0, trials->trials);
  return numbers->ok();
}

std::optional<DirectionTrials> ReadDirection(Numbers* numbers) {
  DirectionTrials trials;
  if (!ReadCounts(numbers, &trials)) return std::nullopt;
  int64_t sum = trials.missed;
  while (!numbers->is_at_end()) {
    DifferenceCount difference;
    for (int16_t& steps : difference.steps) {
      steps = static_cast<int16_t>(numbers->Next(-kMostSteps, kMostSteps));
    }
    difference.count = numbers->Next(1, trials.trials);
    if (!trials.differences.empty() && difference.steps <= trials.differences.back().steps) {
      return std::nullopt;
    }
    sum += difference.count;
    trials.differences.push_back(difference);
  }
  if (!numbers->ok() || sum != trials.trials) return std::nullopt;
  return trials;
}

std::optional<RowTrials> ReadRow(Numbers* numbers, int num_cells) {
  RowTrials trials;
  if (!ReadCounts(numbers, &trials)) return std::nullopt;
  int64_t sum = trials.missed;
  while (!numbers->is_at_end()) {
    const int32_t lowest = trials.detected.empty() ? 0 : trials.detected.back().ordinal + 1;
    RowTrials::Count detected;
    detected.ordinal = numbers->Next(lowest, num_cells - 1);
    detected.count = numbers->Next(1, trials.trials);
    sum += detected.count;
    trials.detected.push_back(detected);
  }
  if (!numbers->ok() || sum != trials.trials) return std::nullopt;
  return trials;
}

// Number of the line, from 1, that a position is in.
std::ptrdiff_t LineAt(std::string_view text, size_t position) {
  return 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(position), '\n');
}

std::string LineAround(std::string_view text, size_t position) {
  constexpr size_t kLongest = 80;
  const size_t before = position == 0 ? std::string_view::npos : text.rfind('\n', position - 1);
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

std::string DirectionLine(int32_t direction, const DirectionTrials& trials) {
  std::string line = Format("direction %d %d %d", direction, trials.trials, trials.missed);
  for (const DifferenceCount& difference : trials.differences) {
    const auto& [x, y, z] = difference.steps;
    line += Format(" %d %d %d %d", int{x}, int{y}, int{z}, difference.count);
  }
  return WithChecksum(std::move(line));
}

std::string RowLine(int32_t ordinal, const RowTrials& trials) {
  std::string line = Format("row %d %d %d", ordinal, trials.trials, trials.missed);
  for (const RowTrials::Count& detected : trials.detected) {
    line += Format(" %d %d", detected.ordinal, detected.count);
  }
  return WithChecksum(std::move(line));
}

Result<WorkFile> WorkFile::Open(const std::filesystem::path& file, const ContingencyKey& key) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor < 0) return SystemError(file, "opened");
  WorkFile work(file, key, descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::kUnavailable,
                 Format("%s is in use by another run, expected to have it alone", file.c_str())};
  }
  if (Result<void> loaded = work.Load(); !loaded) return loaded.error();
  return work;
}

WorkFile::WorkFile(std::filesystem::path file, const ContingencyKey& key, int descriptor)
    : file_(std::move(file)), descriptor_(descriptor) {
  table_.key = key;
  table_.directions.resize(static_cast<size_t>(key.num_directions));
  if (key.rows_k > 0) num_row_cells_ = So3Grid(key.rows_k).num_cells();
}

WorkFile::WorkFile(WorkFile&& other) noexcept
    : file_(std::move(other.file_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      num_row_cells_(other.num_row_cells_),
      size_(other.size_),
      table_(std::move(other.table_)) {}

WorkFile::~WorkFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> WorkFile::Load() {
  const Result<std::string> bytes = ReadAll(descriptor_, file_);
  if (!bytes) return bytes.error();
  const std::string_view text = *bytes;
  size_ = text.size();
  const Result<size_t> header_end = CheckHeader(text);
  if (!header_end) return header_end.error();
  for (size_t position = *header_end; position < text.size();) {
    const size_t end = text.find('\n', position);
    // Only the last line is ever cut short.
    if (end == std::string_view::npos) return CutTo(position);
    if (!Take(text.substr(position, end - position))) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s, line %td: not the whole record of a direction or row of this table, "
                          "each there once; remove the file to measure anew",
                          file_.c_str(),
                          LineAt(text, position))};
    }
    position = end + 1;
  }
  return {};
}

// Where the header ends. It is written when all that is there is a part of it.
Result<size_t> WorkFile::CheckHeader(std::string_view text) {
  const std::string header = Header(table_.key);
  if (text.substr(0, header.size()) == header) return header.size();
  const auto [differ, unused] =
      std::mismatch(text.begin(), text.end(), header.begin(), header.end());
  if (differ == text.end()) {
    if (Result<void> cut = CutTo(0); !cut) return cut.error();
    if (Result<void> written = Write(header); !written) return written.error();
    return header.size();
  }
  const auto position = static_cast<size_t>(differ - text.begin());
  return Error{ErrorCode::kInvalidArgument,
               Format("%s, line %td: trials of another table: \"%s\", expected \"%s\"; "
                      "remove the file to measure anew",
                      file_.c_str(),
                      LineAt(text, position),
                      LineAround(text, position).c_str(),
                      LineAround(header, position).c_str())};
}

// False when a line is not a record with its checksum of what is not there yet.
bool WorkFile::Take(std::string_view line) {
  const size_t mark = line.rfind(" #");
  if (mark == std::string_view::npos) return false;
  const std::string_view record = line.substr(0, mark);
  if (line.substr(mark) != Format(" #%016jx", static_cast<uintmax_t>(Fnv1a(record)))) return false;
  const size_t blank = record.find(' ');
  if (blank == std::string_view::npos) return false;
  const std::string_view kind = record.substr(0, blank);
  Numbers numbers(record.substr(blank));
  if (kind == "direction") {
    const int32_t direction = numbers.Next(0, table_.key.num_directions - 1);
    std::optional<DirectionTrials> trials = ReadDirection(&numbers);
    if (!trials) return false;
    DirectionTrials& place = table_.directions[static_cast<size_t>(direction)];
    if (place.trials != 0) return false;
    place = std::move(*trials);
    return true;
  }
  if (kind != "row") return false;
  const int32_t ordinal = numbers.Next(0, num_row_cells_ - 1);
  std::optional<RowTrials> trials = ReadRow(&numbers, num_row_cells_);
  return trials && table_.rows.emplace(ordinal, std::move(*trials)).second;
}

Result<void> WorkFile::AppendDirection(int32_t direction, DirectionTrials trials) {
  VANTAGE_CHECK(direction >= 0 && direction < table_.key.num_directions,
                Format("direction %d", direction));
  DirectionTrials& place = table_.directions[static_cast<size_t>(direction)];
  VANTAGE_CHECK(place.trials == 0 && trials.trials > 0, Format("direction %d", direction));
  if (Result<void> written = Write(DirectionLine(direction, trials)); !written) return written;
  place = std::move(trials);
  return {};
}

Result<void> WorkFile::AppendRow(int32_t ordinal, RowTrials trials) {
  VANTAGE_CHECK(ordinal >= 0 && ordinal < num_row_cells_ && !table_.rows.contains(ordinal) &&
                    trials.trials > 0,
                Format("row %d", ordinal));
  if (Result<void> written = Write(RowLine(ordinal, trials)); !written) return written;
  table_.rows.emplace(ordinal, std::move(trials));
  return {};
}

Result<void> WorkFile::Remove() {
  if (::unlink(file_.c_str()) != 0) return SystemError(file_, "removed");
  return {};
}

Result<void> WorkFile::Write(std::string_view text) {
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

Result<void> WorkFile::CutTo(size_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) return SystemError(file_, "cut");
  size_ = size;
  return {};
}

}  // namespace vantage
