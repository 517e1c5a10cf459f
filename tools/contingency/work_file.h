#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"
#include "fusion/confusion/contingency_table.h"
#include "tools/support/growing_file.h"

namespace vantage {

/// What is measured of a table so far: a text file of its key and one line a finished direction or
/// row, in any order, each with a checksum. A process that is killed while it writes leaves all but
/// the last line whole. The file is locked while it is open.
class WorkFile {
 public:
  /// Makes the file if it isn't there. A last line that is not whole is cut off: what it was of is
  /// measured again.
  /// Errors: the system refuses, another process has the file open, it is of another key (names the
  /// line that differs), or is damaged elsewhere; the message names file and line.
  static Result<WorkFile> Open(const std::filesystem::path& file, const ContingencyKey& key);

  /// All that the file holds.
  [[nodiscard]] const ContingencyTable& table() const { return table_; }

  /// Each adds what is not there yet. Errors: the system refuses; the file is then as before.
  Result<void> AppendDirection(int32_t direction, DirectionTrials trials);
  Result<void> AppendRow(int32_t ordinal, RowTrials trials);

  /// Removes the file: all of it is elsewhere now.
  Result<void> Remove() { return file_.Remove(); }

 private:
  WorkFile(GrowingFile file, const ContingencyKey& key);
  Result<void> Load();
  Result<size_t> CheckHeader(std::string_view text);
  bool Take(std::string_view line);

  GrowingFile file_;
  int num_row_cells_ = 0;
  ContingencyTable table_;
};

/// The lines of one direction or row, for the file.
std::string DirectionLine(int32_t direction, const DirectionTrials& trials);
std::string RowLine(int32_t ordinal, const RowTrials& trials);

}  // namespace vantage
