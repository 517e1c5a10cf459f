#include "fusion/confusion/contingency_file.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/so3_grid.h"

namespace vantage {
namespace {

// Trials with normal errors about the identity and, for every second trial, a half turn about z.
DirectionTrials RandomTrials(int trials, Rng& rng) {
  std::map<std::array<int16_t, 3>, int32_t> counts;
  DirectionTrials direction;
  direction.trials = trials;
  for (int i = 0; i < trials; ++i) {
    if (rng.Uniform() < 0.02) {
      ++direction.missed;
      continue;
    }
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Quaterniond mode =
        rng.Below(2) == 0 ? Eigen::Quaterniond::Identity() : Eigen::Quaterniond(0, 0, 0, 1);
    ++counts[DifferenceCount::StepsOf(mode * ExpSo3(0.3 * kDegree * error))];
  }
  for (const auto& [steps, count] : counts) direction.differences.push_back({steps, count});
  return direction;
}

ContingencyTable Table(int num_directions, int trials) {
  ContingencyTable table;
  table.key.model_id = "mug";
  table.key.mesh_hash = "0123456789abcdef";
  table.key.estimator = "ppf";
  table.key.estimator_parameters = "sampling 0.05\nangle_bins 30\n";
  table.key.sensor = "fx 525 0.6 to 0.9 m";
  table.key.stopping = "250";
  table.key.seed = 0xfedcba9876543210ULL;
  table.key.num_directions = num_directions;
  table.key.rows_k = 8;
  Rng rng(7);
  for (int i = 0; i < num_directions; ++i) table.directions.push_back(RandomTrials(trials, rng));
  if (num_directions > 2) table.directions[1] = {};
  table.rows[0] = {5, 1, {{0, 3}, {8479, 1}}};
  table.rows[8479] = {2, 2, {}};
  return table;
}

std::string MessageOf(const std::string& bytes) {
  const Result<ContingencyTable> table = DecodeContingencyTable(bytes, "some.file");
  if (table.ok()) return {};
  EXPECT_NE(table.error().message.find("some.file"), std::string::npos);
  return table.error().message;
}

// A file whose frame is right, around any content.
std::string Framed(const std::string& content, uint32_t version, uint64_t claimed) {
  std::string bytes = "VCONTING";
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(version >> (8 * i)));
  for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<char>(claimed >> (8 * i)));
  std::string packed(compressBound(content.size()), '\0');
  uLongf size = packed.size();
  compress(reinterpret_cast<Bytef*>(packed.data()),
           &size,
           reinterpret_cast<const Bytef*>(content.data()),
           content.size());
  bytes += packed.substr(0, size);
  const auto crc =
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()));
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(crc >> (8 * i)));
  return bytes;
}

std::string Unpacked(const std::string& bytes) {
  std::string content(1 << 20, '\0');
  uLongf size = content.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(content.data()),
                       &size,
                       reinterpret_cast<const Bytef*>(bytes.data()) + 20,
                       bytes.size() - 24),
            Z_OK);
  content.resize(size);
  return content;
}

TEST(ContingencyFile, ReadsWhatItWrote) {
  for (const int n : {0, 2, 40}) {
    const ContingencyTable table = Table(n, 60);
    const std::string bytes = EncodeContingencyTable(table);
    const Result<ContingencyTable> read = DecodeContingencyTable(bytes, "t");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(*read, table);
    EXPECT_EQ(EncodeContingencyTable(*read), bytes);
  }
  ContingencyTable empty;
  EXPECT_EQ(*DecodeContingencyTable(EncodeContingencyTable(empty), "t"), empty);
  ContingencyTable rows_alone = Table(0, 0);
  rows_alone.key.num_directions = 391;
  EXPECT_EQ(*DecodeContingencyTable(EncodeContingencyTable(rows_alone), "t"), rows_alone);
}

TEST(ContingencyFile, KeepsTheExtremes) {
  ContingencyTable table;
  table.key.num_directions = 2;
  table.key.rows_k = So3Grid::kSmallest;
  constexpr int32_t kMost = std::numeric_limits<int32_t>::max();
  table.directions = {{kMost, 0, {{{-722, -722, -722}, 1}, {{722, 722, 722}, kMost - 1}}},
                      {kMost, kMost, {}}};
  table.rows[So3Grid(2).num_cells() - 1] = {kMost, kMost - 1, {{0, 1}}};
  const Result<ContingencyTable> read = DecodeContingencyTable(EncodeContingencyTable(table), "t");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(*read, table);
}

TEST(ContingencyFile, RefusesEveryTruncationAndBitFlip) {
  const std::string bytes = EncodeContingencyTable(Table(4, 30));
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(MessageOf(bytes.substr(0, size)).empty()) << size;
  }
  for (size_t i = 0; i < bytes.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = bytes;
      flipped[i] = static_cast<char>(flipped[i] ^ (1 << bit));
      EXPECT_FALSE(MessageOf(flipped).empty()) << i;
    }
  }
  EXPECT_FALSE(MessageOf(bytes + "x").empty());
}

TEST(ContingencyFile, SaysWhatAFileIsNot) {
  const std::string foreign = "is not a contingency table";
  EXPECT_NE(MessageOf("").find(foreign), std::string::npos);
  EXPECT_NE(MessageOf("VCONT").find(foreign), std::string::npos);
  EXPECT_NE(MessageOf(std::string(1000, '\0')).find(foreign), std::string::npos);
  EXPECT_NE(MessageOf("\x7f"
                      "ELF and so on and so on and on")
                .find(foreign),
            std::string::npos);
  EXPECT_NE(MessageOf(Framed("", 7, 0)).find("version 7, this program reads up to 1"),
            std::string::npos);
  EXPECT_NE(MessageOf(Framed("", 0, 0)).find("version 0"), std::string::npos);
  EXPECT_NE(MessageOf("VCONTING").find("cut off"), std::string::npos);
}

TEST(ContingencyFile, DoesNotBelieveTheSizeOfItsContent) {
  const std::string content = Unpacked(EncodeContingencyTable(Table(4, 30)));
  EXPECT_TRUE(MessageOf(Framed(content, 1, content.size())).empty());
  for (const uint64_t claimed : {uint64_t{0},
                                 uint64_t{content.size() - 1},
                                 uint64_t{content.size() + 1},
                                 uint64_t{1} << 40U,
                                 ~uint64_t{0}}) {
    EXPECT_FALSE(MessageOf(Framed(content, 1, claimed)).empty()) << claimed;
  }
}

// Content with a right frame: whatever it says, there is a table or an error.
TEST(ContingencyFile, SurvivesHostileContent) {
  const std::string content = Unpacked(EncodeContingencyTable(Table(4, 30)));
  for (size_t size = 0; size < content.size(); ++size) {
    EXPECT_FALSE(MessageOf(Framed(content.substr(0, size), 1, size)).empty()) << size;
  }
  EXPECT_FALSE(MessageOf(Framed(content + '\0', 1, content.size() + 1)).empty());
  Rng rng(8);
  int num_refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string changed = content;
    for (uint32_t j = 0; j <= rng.Below(3); ++j) {
      const size_t at = rng.Below(static_cast<uint32_t>(content.size()));
      changed[at] = static_cast<char>(i % 2 == 0 ? 0xff : rng.Below(256));
    }
    const std::string bytes = Framed(changed, 1, changed.size());
    const Result<ContingencyTable> table = DecodeContingencyTable(bytes, "t");
    num_refused += table.ok() ? 0 : 1;
    if (!table.ok()) continue;
    // What passes holds its invariants.
    for (const DirectionTrials& direction : table->directions) {
      int64_t sum = direction.missed;
      for (const DifferenceCount& difference : direction.differences) sum += difference.count;
      ASSERT_EQ(sum, direction.trials);
    }
    for (const auto& [ordinal, row] : table->rows) {
      const int num_cells = So3Grid(table->key.rows_k).num_cells();
      ASSERT_TRUE(ordinal >= 0 && ordinal < num_cells);
      for (const RowTrials::Count& count : row.detected) {
        ASSERT_TRUE(count.ordinal >= 0 && count.ordinal < num_cells);
      }
    }
  }
  EXPECT_GT(num_refused, 3000);
}

TEST(ContingencyFile, CountsThatDontAddUpAreRefused) {
  const auto message = [](auto&& change) {
    ContingencyTable table = Table(3, 30);
    change(&table);
    return MessageOf(EncodeContingencyTable(table));
  };
  const auto expect = [&](const std::string& part, auto&& change) {
    const std::string text = message(change);
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  expect("outcomes of 31 trials", [](ContingencyTable* t) { t->directions[0].trials = 31; });
  expect("missed", [](ContingencyTable* t) { t->directions[0].missed = 31; });
  expect("at most", [](ContingencyTable* t) { t->directions[0].trials = -1; });
  expect("ascend", [](ContingencyTable* t) {
    std::swap(t->directions[0].differences[0], t->directions[0].differences[1]);
  });
  expect("0 times", [](ContingencyTable* t) { t->directions[0].differences[0].count = 0; });
  expect("step", [](ContingencyTable* t) { t->directions[0].differences[0].steps[0] = -5000; });
  expect("expected 0 or 4", [](ContingencyTable* t) { t->key.num_directions = 4; });
  expect("directions", [](ContingencyTable* t) { t->key.num_directions = 1; });
  expect("at most 100000", [](ContingencyTable* t) { t->key.num_directions = 100'001; });
  expect("k of the rows 129", [](ContingencyTable* t) { t->key.rows_k = 129; });
  expect("k = 1", [](ContingencyTable* t) { t->key.rows_k = 1; });
  expect("rows of no grid", [](ContingencyTable* t) { t->key.rows_k = 0; });
  expect("row 8479, expected below", [](ContingencyTable* t) {
    t->key.rows_k = 7;
    t->rows.erase(0);
  });
  expect("cell 8480, expected below 8480",
         [](ContingencyTable* t) { t->rows[0].detected[1].ordinal = 8480; });
  expect("outcomes of 6 trials", [](ContingencyTable* t) { t->rows[0].trials = 6; });
}

TEST(ContingencyFile, IsWrittenWholeOrNotAtAll) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "contingency_file_test";
  std::filesystem::remove_all(folder);
  const std::filesystem::path file = folder / "mug.contingency";
  const ContingencyTable table = Table(4, 30);
  Result<void> written = WriteContingencyTable(table, file);
  ASSERT_FALSE(written.ok());  // No such folder.
  EXPECT_NE(written.error().message.find(file.string()), std::string::npos);
  Result<ContingencyTable> read = ReadContingencyTable(file);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::kNotFound);

  std::filesystem::create_directories(folder);
  ASSERT_TRUE(WriteContingencyTable(Table(2, 10), file).ok());
  ASSERT_TRUE(WriteContingencyTable(table, file).ok());  // In place of the first.
  read = ReadContingencyTable(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(*read, table);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);

  ASSERT_FALSE(ReadContingencyTable(folder).ok());
  std::filesystem::create_directories(folder / "taken" / "by_a_folder");
  ASSERT_FALSE(WriteContingencyTable(table, folder / "taken").ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2);
  std::ofstream(folder / "empty").close();
  EXPECT_NE(ReadContingencyTable(folder / "empty").error().message.find("not a contingency table"),
            std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST(ContingencyFile, ATableOfFineDirectionsIsSmall) {
  const ContingencyTable table = Table(600, 279);  // A tenth of k = 32.
  EXPECT_LT(EncodeContingencyTable(table).size(), 400'000U);
}

TEST(CheckContingencyKey, NamesWhatDiffers) {
  const ContingencyKey key = Table(0, 0).key;
  EXPECT_TRUE(CheckContingencyKey(key, key, "t").ok());
  EXPECT_TRUE(CheckContingencyKey(key, {}, "t").ok());
  ContingencyKey other = key;
  other.num_directions = 77;
  other.rows_k = 2;
  other.seed = 2;
  other.stopping = "else";
  EXPECT_TRUE(CheckContingencyKey(key, other, "t").ok());
  other.estimator = "shot";
  const Result<void> wrong = CheckContingencyKey(key, other, "mug.contingency");
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("mug.contingency"), std::string::npos);
  EXPECT_NE(wrong.error().message.find("estimator is \"ppf\", expected \"shot\""),
            std::string::npos)
      << wrong.error().message;
}

}  // namespace
}  // namespace vantage
