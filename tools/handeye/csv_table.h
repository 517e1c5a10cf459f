#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A CSV file whose first line names the columns. Lines that are empty or begin with '#' are
/// skipped.
class CsvTable {
 public:
  /// Errors: absent, larger than 64 MiB, no columns, a column named twice, a row with another
  /// number of fields than there are columns.
  static Result<CsvTable> Read(const std::filesystem::path& file);

  [[nodiscard]] size_t num_rows() const { return rows_.size(); }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] std::optional<size_t> Column(const std::string& name) const;
  [[nodiscard]] const std::string& Text(size_t row, size_t column) const {
    return rows_[row][column];
  }
  /// Errors: no finite number, named by file, line and column.
  [[nodiscard]] Result<double> Number(size_t row, size_t column) const;
  /// "FILE:LINE".
  [[nodiscard]] std::string Place(size_t row) const;

 private:
  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
  std::vector<int> lines_;
};

}  // namespace vantage
