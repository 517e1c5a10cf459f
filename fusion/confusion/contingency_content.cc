#include "fusion/confusion/contingency_content.h"

#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>

#include "common/format.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/so3_grid.h"

namespace vantage {
namespace {

constexpr int kHighestStep = 722;  // Half a turn and the rounding.

// Seven bits a byte, lowest first.
void Append(uint64_t value, std::string* bytes) {
  while (value >= 0x80) {
    bytes->push_back(static_cast<char>((value & 0x7FU) | 0x80U));
    value >>= 7U;
  }
  bytes->push_back(static_cast<char>(value));
}

void Append(int32_t value, std::string* bytes) { Append(static_cast<uint64_t>(value), bytes); }

// Small numbers of either sign in one byte.
void AppendSigned(int value, std::string* bytes) {
  Append(value < 0 ? -2 * value - 1 : 2 * value, bytes);
}

void Append(const std::string& text, std::string* bytes) {
  Append(uint64_t{text.size()}, bytes);
  *bytes += text;
}

// Reads content and remembers the first thing that is wrong. After it everything is 0.
class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes) {}

  [[nodiscard]] bool ok() const { return error_.empty(); }
  [[nodiscard]] const std::string& error() const { return error_; }
  [[nodiscard]] size_t remaining() const { return bytes_.size() - at_; }

  void Fail(std::string error) {
    if (ok()) error_ = std::move(error);
  }

  /// A number up to `most`; `what` it is for the message.
  uint64_t Number(const char* what, uint64_t most) {
    uint64_t value = 0;
    for (unsigned shift = 0; ok(); shift += 7) {
      if (remaining() == 0 || shift > 63) {
        Fail(Format("ends within the %s or its number is longer than 64 bits", what));
        break;
      }
      const auto byte = static_cast<unsigned char>(bytes_[at_++]);
      value |= uint64_t{byte & 0x7FU} << shift;
      if ((byte & 0x80U) == 0) break;
    }
    if (value > most) {
      Fail(Format("has %s %ju, expected at most %ju", what, uintmax_t{value}, uintmax_t{most}));
    }
    return ok() ? value : 0;
  }

  int32_t Int(const char* what, int32_t most = std::numeric_limits<int32_t>::max()) {
    return static_cast<int32_t>(Number(what, static_cast<uint64_t>(most)));
  }

  /// How many things follow that take `least_bytes` each.
  size_t Count(const char* what, size_t least_bytes) {
    const uint64_t count = Number(what, bytes_.size());
    if (count > remaining() / least_bytes) {
      Fail(Format("claims %ju %s in %zu bytes", uintmax_t{count}, what, remaining()));
    }
    return ok() ? static_cast<size_t>(count) : 0;
  }

  int Signed(const char* what) {
    const int32_t value = Int(what, 4 * kHighestStep + 1);
    return (value & 1) == 0 ? value / 2 : -(value + 1) / 2;
  }

  std::string Text(const char* what) {
    const size_t size = Count(what, 1);
    if (!ok()) return {};
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }

 private:
  const std::string& bytes_;
  size_t at_ = 0;
  std::string error_;
};

void ReadDirection(Reader* reader, DirectionTrials* direction) {
  direction->trials = reader->Int("trials of a direction");
  direction->missed = reader->Int("missed trials of a direction", direction->trials);
  const size_t count = reader->Count("differences of a direction", 4);
  direction->differences.reserve(count);
  std::array<int16_t, 3> last{};
  int64_t sum = direction->missed;
  for (size_t j = 0; j < count && reader->ok(); ++j) {
    DifferenceCount difference;
    for (size_t i = 0; i < 3; ++i) {
      const int steps = last[i] + reader->Signed("steps of a difference");
      if (std::abs(steps) > kHighestStep) {
        reader->Fail(
            Format("has a difference of %d steps, expected at most %d", steps, kHighestStep));
        return;
      }
      difference.steps[i] = static_cast<int16_t>(steps);
    }
    difference.count = reader->Int("count of a difference");
    sum += difference.count;
    if (difference.count == 0) reader->Fail("has a difference that was seen 0 times");
    if (j > 0 && difference.steps <= last) reader->Fail("has differences that do not ascend");
    last = difference.steps;
    direction->differences.push_back(difference);
  }
  if (sum != direction->trials) {
    reader->Fail(
        Format("has a direction with %jd outcomes of %d trials", intmax_t{sum}, direction->trials));
  }
}

void ReadRow(Reader* reader, int num_cells, RowTrials* row) {
  row->trials = reader->Int("trials of a row");
  row->missed = reader->Int("missed trials of a row", row->trials);
  const size_t count = reader->Count("detected cells of a row", 2);
  row->detected.reserve(count);
  int64_t ordinal = 0;
  int64_t sum = row->missed;
  for (size_t j = 0; j < count && reader->ok(); ++j) {
    const int32_t step = reader->Int("detected cell of a row");
    ordinal += step;
    const int32_t times = reader->Int("count of a detected cell");
    sum += times;
    if (times == 0) reader->Fail("has a detected cell that was seen 0 times");
    if (j > 0 && step == 0) reader->Fail("has detected cells that do not ascend");
    if (ordinal >= num_cells) {
      reader->Fail(Format("has cell %jd, expected below %d", intmax_t{ordinal}, num_cells));
      return;
    }
    row->detected.push_back({static_cast<int32_t>(ordinal), times});
  }
  if (sum != row->trials) {
    reader->Fail(Format("has a row with %jd outcomes of %d trials", intmax_t{sum}, row->trials));
  }
}

void ReadKey(Reader* reader, ContingencyKey* key) {
  key->model_id = reader->Text("model's name");
  key->mesh_hash = reader->Text("mesh's hash");
  key->estimator = reader->Text("estimator's name");
  key->estimator_parameters = reader->Text("estimator's parameters");
  key->sensor = reader->Text("sensor's text");
  key->stopping = reader->Text("text of stopping");
  key->seed = reader->Number("seed", std::numeric_limits<uint64_t>::max());
  key->num_directions = reader->Int("number of directions", DirectionGrid::kMost);
  key->rows_k = reader->Int("k of the rows", So3Grid::kLargest);
  if (key->num_directions != 0 && key->num_directions < DirectionGrid::kFewest) {
    reader->Fail(Format("has %d directions, expected 0 or at least %d",
                        key->num_directions,
                        DirectionGrid::kFewest));
  }
  if (key->rows_k != 0 && key->rows_k < So3Grid::kSmallest) {
    reader->Fail(
        Format("has rows of k = %d, expected 0 or at least %d", key->rows_k, So3Grid::kSmallest));
  }
}

void ReadRows(Reader* reader, ContingencyTable* table) {
  const size_t num_rows = reader->Count("rows", 4);
  if (!reader->ok() || num_rows == 0) return;
  if (table->key.rows_k == 0) {
    reader->Fail(Format("has %zu rows of no grid, expected 0", num_rows));
    return;
  }
  const int num_cells = So3Grid(table->key.rows_k).num_cells();
  int64_t ordinal = 0;
  for (size_t i = 0; i < num_rows && reader->ok(); ++i) {
    const int32_t step = reader->Int("row");
    ordinal += step;
    if (i > 0 && step == 0) reader->Fail("has rows that do not ascend");
    if (ordinal >= num_cells) {
      reader->Fail(Format("has row %jd, expected below %d", intmax_t{ordinal}, num_cells));
      return;
    }
    ReadRow(reader, num_cells, &table->rows[static_cast<int32_t>(ordinal)]);
  }
}

}  // namespace

std::string EncodeContent(const ContingencyTable& table) {
  const ContingencyKey& key = table.key;
  std::string bytes;
  for (const std::string* text : {&key.model_id,
                                  &key.mesh_hash,
                                  &key.estimator,
                                  &key.estimator_parameters,
                                  &key.sensor,
                                  &key.stopping}) {
    Append(*text, &bytes);
  }
  Append(key.seed, &bytes);
  Append(key.num_directions, &bytes);
  Append(key.rows_k, &bytes);

  Append(uint64_t{table.directions.size()}, &bytes);
  for (const DirectionTrials& direction : table.directions) {
    Append(direction.trials, &bytes);
    Append(direction.missed, &bytes);
    Append(uint64_t{direction.differences.size()}, &bytes);
    std::array<int16_t, 3> last{};
    for (const DifferenceCount& difference : direction.differences) {
      for (size_t i = 0; i < 3; ++i) AppendSigned(difference.steps[i] - last[i], &bytes);
      Append(difference.count, &bytes);
      last = difference.steps;
    }
  }

  Append(uint64_t{table.rows.size()}, &bytes);
  int32_t last_row = 0;
  for (const auto& [ordinal, row] : table.rows) {
    Append(ordinal - last_row, &bytes);
    Append(row.trials, &bytes);
    Append(row.missed, &bytes);
    Append(uint64_t{row.detected.size()}, &bytes);
    int32_t last = 0;
    for (const RowTrials::Count& detected : row.detected) {
      Append(detected.ordinal - last, &bytes);
      Append(detected.count, &bytes);
      last = detected.ordinal;
    }
    last_row = ordinal;
  }
  return bytes;
}

std::string DecodeContent(const std::string& content, ContingencyTable* table) {
  Reader reader(content);
  ReadKey(&reader, &table->key);
  const size_t num_directions = reader.Count("measured directions", 3);
  if (num_directions != 0 && num_directions != static_cast<size_t>(table->key.num_directions)) {
    reader.Fail(
        Format("has %zu directions, expected 0 or %d", num_directions, table->key.num_directions));
  }
  if (reader.ok()) table->directions.resize(num_directions);
  for (DirectionTrials& direction : table->directions) {
    if (reader.ok()) ReadDirection(&reader, &direction);
  }
  ReadRows(&reader, table);
  if (reader.remaining() != 0) {
    reader.Fail(Format("has %zu bytes after the last row, expected 0", reader.remaining()));
  }
  return reader.error();
}

}  // namespace vantage
