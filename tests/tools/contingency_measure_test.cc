// Measuring with a made-up detector: what a table holds depends on neither threads, shards nor
// interruptions.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>

#include "common/rng.h"
#include "fusion/confusion/contingency_file.h"
#include "fusion/confusion/viewing_direction.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "tools/contingency/left_invariance.h"
#include "tools/contingency/measure_table.h"
#include "tools/contingency/table_text.h"
#include "tools/contingency/trial_units.h"
#include "tools/contingency/work_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// Turned by a half turn about z as often as the object is seen from above, missed at times.
std::optional<Eigen::Quaterniond> Detect(const Eigen::Quaterniond& q_camera_object, uint64_t seed) {
  Rng rng(seed);
  if (rng.Uniform() < 0.05) return std::nullopt;
  const double above = std::max(0.0, ViewingDirection(q_camera_object).z());
  Eigen::Quaterniond difference = ExpSo3(0.02 * rng.UnitVector());
  if (rng.Uniform() < 0.5 * above) {
    difference = difference * Eigen::Quaterniond(0.0, 0.0, 0.0, 1.0);
  }
  return q_camera_object * difference;
}

// Sees worse when the camera is upside down: no left invariance.
std::optional<Eigen::Quaterniond> DetectByRoll(const Eigen::Quaterniond& q_camera_object,
                                               uint64_t seed) {
  Rng rng(seed);
  const Eigen::Quaterniond at_no_roll = OrientationSeenFrom(ViewingDirection(q_camera_object), 0.0);
  const Eigen::Quaterniond turn = q_camera_object * at_no_roll.conjugate();
  if (rng.Uniform() < 0.9 * std::abs(turn.z())) return std::nullopt;
  return q_camera_object;
}

TrialDetectorFactory Factory() {
  return []() -> Result<TrialDetector> { return TrialDetector(Detect); };
}

class MeasureTableTest : public ScratchTest {
 protected:
  MeasureTableTest() {
    key_.model_id = plan_.model_id = "made-up";
    key_.estimator = "none";
    key_.estimator_parameters = "first 1\nsecond 2\n";
    key_.seed = plan_.seed;
    key_.stopping = plan_.stopping.Text();
    key_.num_directions = 30;
    key_.rows_k = 4;
    units_.directions.resize(30);
    std::iota(units_.directions.begin(), units_.directions.end(), 0);
    units_.rows = {3, 17, 200};
  }
  [[nodiscard]] fs::path File() const { return scratch() / "table.trials"; }
  [[nodiscard]] WorkFile Open() const {
    Result<WorkFile> work = WorkFile::Open(File(), key_);
    EXPECT_TRUE(work.ok()) << (work.ok() ? "" : work.error().message);
    return std::move(work).value();
  }
  [[nodiscard]] ContingencyTable Measured(const TrialUnits& units, int threads) const {
    ContingencyTable table;
    {
      WorkFile work = Open();
      const Result<bool> done = MeasureTable(plan_, units, threads, Factory(), {}, {}, &work);
      EXPECT_TRUE(done.ok() && *done);
      table = work.table();
    }
    fs::remove(File());
    return table;
  }
  void ExpectRefused(const std::string& part) const {
    const Result<WorkFile> work = WorkFile::Open(File(), key_);
    ASSERT_FALSE(work.ok());
    EXPECT_NE(work.error().message.find(part), std::string::npos) << work.error().message;
  }
  [[nodiscard]] std::string Text() const { return *ReadFileBytes(File(), 1U << 24U); }

  TrialPlan plan_;
  ContingencyKey key_;
  TrialUnits units_;
};

TEST_F(MeasureTableTest, TheSameForAnyNumberOfThreadsAndShards) {
  const ContingencyTable one = Measured(units_, 1);
  EXPECT_TRUE(one.IsComplete());
  EXPECT_EQ(one.rows.size(), 3U);
  const std::string bytes = EncodeContingencyTable(one);
  EXPECT_EQ(EncodeContingencyTable(Measured(units_, 4)), bytes);
  std::vector<ContingencyTable> parts;
  for (int i = 3; i >= 1; --i) parts.push_back(Measured(UnitsOf({i, 3}, units_), 2));
  EXPECT_EQ(MissingDirections(parts.front()).size(), 20U);
  const Result<ContingencyTable> merged = MergeTables(parts);
  ASSERT_TRUE(merged.ok()) << merged.error().message;
  EXPECT_EQ(EncodeContingencyTable(*merged), bytes);
  plan_.seed = 2;
  EXPECT_NE(EncodeContingencyTable(Measured(units_, 1)), bytes);
}

TEST_F(MeasureTableTest, GoesOnAfterAnInterruption) {
  const ContingencyTable whole = Measured(units_, 1);
  std::stop_source source;
  int64_t first_done = 0;
  {
    WorkFile work = Open();
    const auto stop_at_seven = [&](const MeasureProgress& progress) {
      first_done = progress.units_done;
      if (progress.units_done == 7) source.request_stop();
    };
    const Result<bool> done =
        MeasureTable(plan_, units_, 2, Factory(), source.get_token(), stop_at_seven, &work);
    ASSERT_TRUE(done.ok());
    EXPECT_FALSE(*done);
  }
  EXPECT_GE(first_done, 7);
  EXPECT_LE(first_done, 8);
  // As a kill leaves it: the last line is cut.
  fs::resize_file(File(), fs::file_size(File()) - 5);
  WorkFile work = Open();
  int64_t at_start = -1;
  const Result<bool> done = MeasureTable(
      plan_,
      units_,
      2,
      Factory(),
      {},
      [&](const MeasureProgress& progress) {
        if (at_start < 0) at_start = progress.units_done;
      },
      &work);
  ASSERT_TRUE(done.ok() && *done);
  EXPECT_EQ(at_start, first_done - 1);
  EXPECT_EQ(work.table(), whole);
}

TEST_F(MeasureTableTest, HoldsTheOutcomesShares) {
  plan_.stopping.least_trials = plan_.stopping.most_trials = 2000;
  units_ = {{0, 29}, {}};
  const ContingencyTable table = Measured(units_, 2);
  EXPECT_EQ(table.NumTrials(), 4000);
  const std::vector<DirectionSummary> summaries = SummarizeDirections(table);
  ASSERT_EQ(summaries.size(), 2U);
  EXPECT_EQ(summaries[0].direction, 0);  // The cap about z.
  EXPECT_NEAR(summaries[0].turned / 2000.0, 0.95 * 0.5 * 0.97, 0.04);
  EXPECT_EQ(summaries[1].turned, 0);
  EXPECT_NEAR(summaries[1].missed / 2000.0, 0.05, 0.02);
}

TEST_F(MeasureTableTest, AFailingDetectorIsTheError) {
  WorkFile work = Open();
  const TrialDetectorFactory fails = []() -> Result<TrialDetector> {
    return Error{ErrorCode::kInvalidArgument, "can't be trained"};
  };
  const Result<bool> done = MeasureTable(plan_, units_, 2, fails, {}, {}, &work);
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().message, "can't be trained");
}

TEST_F(MeasureTableTest, AFileOfAnotherKeyIsRefused) {
  { const WorkFile made = Open(); }
  key_.estimator_parameters = "first 1\nsecond 3\n";
  ExpectRefused("\"  second 2\", expected \"  second 3\"");
  key_.estimator_parameters = "first 1\nsecond 2\n";
  key_.seed = 5;
  ExpectRefused("\"seed 1\", expected \"seed 5\"");
}

TEST_F(MeasureTableTest, AFileInUseIsRefused) {
  const WorkFile work = Open();
  ExpectRefused("in use by another run");
}

TEST_F(MeasureTableTest, DamageIsRefusedAndCutsAreMended) {
  {
    WorkFile work = Open();
    ASSERT_TRUE(MeasureTable(plan_, {{0, 1, 2}, {3}}, 1, Factory(), {}, {}, &work).ok());
  }
  const std::string text = Text();
  const size_t records = text.find("direction 0 ");
  for (size_t size = 0; size < text.size(); size += 7) {
    std::ofstream(File(), std::ios::trunc) << text.substr(0, size);
    const WorkFile work = Open();
    EXPECT_LE(MissingDirections(work.table()).size(), 30U);
  }
  for (size_t at = records; at + 1 < text.size(); at += 3) {
    std::string damaged = text;
    damaged[at] = damaged[at] == '1' ? '2' : '1';
    std::ofstream(File(), std::ios::trunc) << damaged;
    ExpectRefused("remove the file to measure anew");
  }
  // Right checksums of wrong content, and one record twice.
  DirectionTrials wrong{5, 1, {{{1, 2, 3}, 3}}};
  for (const std::string& line : {DirectionLine(4, wrong),
                                  DirectionLine(30, {1, 1, {}}),
                                  DirectionLine(-1, {1, 1, {}}),
                                  DirectionLine(4, {0, 0, {}}),
                                  DirectionLine(4, {2, 0, {{{9000, 0, 0}, 2}}}),
                                  DirectionLine(4, {2, 0, {{{2, 0, 0}, 1}, {{1, 0, 0}, 1}}}),
                                  DirectionLine(0, {1, 1, {}}),
                                  RowLine(100'000'000, {1, 1, {}}),
                                  RowLine(5, {2, 0, {{7, 1}, {7, 1}}})}) {
    std::ofstream(File(), std::ios::trunc) << text + line;
    ExpectRefused("not the whole record");
  }
  std::ofstream(File(), std::ios::trunc) << text + DirectionLine(4, {1, 1, {}});
  EXPECT_EQ(MissingDirections(Open().table()).size(), 26U);
}

TEST_F(MeasureTableTest, LeftInvarianceHoldsOrIsFoundBroken) {
  units_.rows.clear();
  const ContingencyTable table = Measured(units_, 2);
  LeftInvarianceParameters parameters;
  parameters.directions = 6;
  parameters.rolls = 2;
  parameters.rows = 6;
  parameters.trials = 100;
  const auto test = [&](const TrialDetector& detect, int threads) {
    const auto report = TestLeftInvariance(
        table, {}, parameters, threads, [&]() -> Result<TrialDetector> { return detect; }, {}, {});
    EXPECT_TRUE(report.ok() && report->has_value());
    return **report;
  };
  const LeftInvarianceReport holds = test(Detect, 2);
  EXPECT_EQ(holds.tests.size(), 12U);
  EXPECT_EQ(holds.all.num_rejected_by_holm, 0);
  EXPECT_EQ(holds.paper_trials, 200);
  EXPECT_NEAR(holds.unseen.high, 0.05, 1e-3);
  EXPECT_EQ(holds.num_rows, 6);
  EXPECT_LT(std::abs(holds.difference.value), 2.0);
  EXPECT_EQ(ReportJson(holds), ReportJson(test(Detect, 1)));
  EXPECT_NE(ReportText(holds).find("holds at every roll"), std::string::npos);
  EXPECT_GT(test(DetectByRoll, 2).all.num_rejected_by_holm, 0);
}

TEST(TrialUnits, RowsAreParsed) {
  EXPECT_EQ(*ParseRows("7,3-5,4", 10, 1), (std::vector<int32_t>{3, 4, 5, 7}));
  EXPECT_TRUE(ParseRows("", 10, 1)->empty());
  const Result<std::vector<int32_t>> random = ParseRows("random:10", 10, 1);
  ASSERT_TRUE(random.ok());
  EXPECT_EQ(random->size(), 10U);
  EXPECT_NE(*ParseRows("random:20", 8480, 1), *ParseRows("random:20", 8480, 2));
  for (const char* bad : {"10",
                          "5-3",
                          "a",
                          "1,,2",
                          "1,",
                          "-1",
                          "random:0",
                          "random:11",
                          "random:",
                          "1-",
                          "99999999999999999999",
                          "1 2",
                          "3-5-7",
                          "nan"}) {
    EXPECT_FALSE(ParseRows(bad, 10, 1).ok()) << bad;
  }
}

TEST(TrialUnits, ShardsArePartsOfAll) {
  const TrialUnits all{{0, 1, 2, 3, 4}, {10, 20}};
  size_t sum = 0;
  for (int i = 1; i <= 3; ++i) sum += UnitsOf({i, 3}, all).size();
  EXPECT_EQ(sum, all.size());
  EXPECT_EQ(UnitsOf({1, 3}, all), (TrialUnits{{0, 3}, {20}}));
  EXPECT_EQ(UnitsOf({9, 9}, all).size(), 0U);
  for (const char* bad : {"3/2", "0/2", "1/0", "1", "/", "1/", "a/b", "-1/2", "1/200000", ""}) {
    EXPECT_FALSE(ParseShard(bad).ok()) << bad;
  }
  EXPECT_EQ(ParseShard("2/2")->index, 2);
}

TEST(TrialUnits, RangesForPeople) {
  EXPECT_EQ(RangesText({1, 2, 3, 7}, 5), "1-3, 7");
  EXPECT_EQ(RangesText({1, 3, 5}, 2), "1, 3 and 1 more");
  EXPECT_EQ(RangesText({}, 2), "");
}

}  // namespace
}  // namespace vantage
