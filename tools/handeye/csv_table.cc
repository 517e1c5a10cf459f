#include "tools/handeye/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = 64U << 20U;  // bytes

std::string Trimmed(const std::string& text) {
  const char* blanks = " \t\r";
  const size_t begin = text.find_first_not_of(blanks);
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

// Of a line; a field in quotes may hold commas, and "" for a quote.
std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += line[++i];
      } else {
        quoted = !quoted;
      }
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = Trimmed(field);
  return fields;
}

}  // namespace

Result<CsvTable> CsvTable::Read(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  CsvTable table;
  table.file_ = file;
  std::istringstream stream(*bytes);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::string trimmed = Trimmed(line);
    if (trimmed.empty() || trimmed.front() == '#') continue;
    std::vector<std::string> fields = Fields(line);
    if (table.columns_.empty()) {
      table.columns_ = std::move(fields);
      continue;
    }
    if (fields.size() != table.columns_.size()) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s:%d has %zu fields, expected %zu as in its first line",
                          file.c_str(),
                          number,
                          fields.size(),
                          table.columns_.size())};
    }
    table.rows_.push_back(std::move(fields));
    table.lines_.push_back(number);
  }
  if (table.columns_.empty()) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s is empty, expected a line with names of columns", file.c_str())};
  }
  for (size_t i = 0; i < table.columns_.size(); ++i) {
    if (*table.Column(table.columns_[i]) == i) continue;
    return Error{ErrorCode::kCorrupt,
                 Format("%s has the column '%.60s' twice, expected each once",
                        file.c_str(),
                        table.columns_[i].c_str())};
  }
  return table;
}

std::optional<size_t> CsvTable::Column(const std::string& name) const {
  const auto found = std::ranges::find(columns_, name);
  if (found == columns_.end()) return std::nullopt;
  return static_cast<size_t>(found - columns_.begin());
}

Result<double> CsvTable::Number(size_t row, size_t column) const {
  const std::string& text = rows_[row][column];
  double value = 0.0;
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error == std::errc() && stop == end && std::isfinite(value)) return value;
  return Error{ErrorCode::kCorrupt,
               Format("%s: %s = '%.60s', expected a number",
                      Place(row).c_str(),
                      columns_[column].c_str(),
                      text.c_str())};
}

std::string CsvTable::Place(size_t row) const {
  return Format("%s:%d", file_.c_str(), lines_[row]);
}

}  // namespace vantage
