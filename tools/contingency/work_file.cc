#include "tools/contingency/work_file.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "fusion/so3_grid.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr int kMostSteps = 722;  // Of half a turn, and rounding.

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
  Result<GrowingFile> opened = GrowingFile::Open(file);
  if (!opened) return opened.error();
  WorkFile work(std::move(opened).value(), key);
  if (Result<void> loaded = work.Load(); !loaded) return loaded.error();
  return work;
}

WorkFile::WorkFile(GrowingFile file, const ContingencyKey& key) : file_(std::move(file)) {
  table_.key = key;
  table_.directions.resize(static_cast<size_t>(key.num_directions));
  if (key.rows_k > 0) num_row_cells_ = So3Grid(key.rows_k).num_cells();
}

Result<void> WorkFile::Load() {
  const Result<std::string> bytes = file_.Read();
  if (!bytes) return bytes.error();
  const std::string_view text = *bytes;
  const Result<size_t> header_end = CheckHeader(text);
  if (!header_end) return header_end.error();
  for (size_t position = *header_end; position < text.size();) {
    const size_t end = text.find('\n', position);
    // Only the last line is ever cut short.
    if (end == std::string_view::npos) return file_.CutTo(position);
    if (!Take(text.substr(position, end - position))) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s, line %td: not the whole record of a direction or row of this table, "
                          "each there once; remove the file to measure anew",
                          file_.path().c_str(),
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
    if (Result<void> cut = file_.CutTo(0); !cut) return cut.error();
    if (Result<void> written = file_.Append(header); !written) return written.error();
    return header.size();
  }
  const auto position = static_cast<size_t>(differ - text.begin());
  return Error{ErrorCode::kInvalidArgument,
               Format("%s, line %td: trials of another table: \"%s\", expected \"%s\"; "
                      "remove the file to measure anew",
                      file_.path().c_str(),
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
  if (Result<void> written = file_.Append(DirectionLine(direction, trials)); !written)
    return written;
  place = std::move(trials);
  return {};
}

Result<void> WorkFile::AppendRow(int32_t ordinal, RowTrials trials) {
  VANTAGE_CHECK(ordinal >= 0 && ordinal < num_row_cells_ && !table_.rows.contains(ordinal) &&
                    trials.trials > 0,
                Format("row %d", ordinal));
  if (Result<void> written = file_.Append(RowLine(ordinal, trials)); !written) return written;
  table_.rows.emplace(ordinal, std::move(trials));
  return {};
}

}  // namespace vantage
