// Runs vantage-contingency as its users do, on few directions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "common/format.h"
#include "fusion/confusion/contingency_file.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFew = "hub --directions 4 --trials 3 ";

class ContingencyTool : public ToolTest {
 protected:
  ContingencyTool() : ToolTest("vantage-contingency") {}

  [[nodiscard]] std::string Bytes(const std::string& name) const {
    const Result<std::string> bytes = ReadFileBytes(scratch() / name, 1U << 24U);
    EXPECT_TRUE(bytes.ok()) << name;
    return bytes.ok() ? *bytes : "";
  }
  void ExpectRun(const std::string& arguments) const {
    const ProgramOutput output = Run(arguments);
    EXPECT_EQ(output.exit_code, 0) << arguments << ": " << output.text;
  }
};

// A mesh of rings.
void WriteSphere(const fs::path& file) {
  std::ofstream obj(file);
  constexpr int kRings = 32;
  for (int i = 0; i <= kRings; ++i) {
    for (int j = 0; j < 2 * kRings; ++j) {
      const double a = M_PI * i / kRings;
      const double b = M_PI * j / kRings;
      obj << Format("v %.6f %.6f %.6f\n",
                    50 * std::sin(a) * std::cos(b),
                    50 * std::sin(a) * std::sin(b),
                    50 * std::cos(a));
    }
  }
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < 2 * kRings; ++j) {
      const int next = (j + 1) % (2 * kRings);
      const int a = 1 + 2 * kRings * i + j;
      const int b = 1 + 2 * kRings * i + next;
      if (i > 0) obj << Format("f %d %d %d\n", a, a + 2 * kRings, b);
      if (i + 1 < kRings) obj << Format("f %d %d %d\n", b, a + 2 * kRings, b + 2 * kRings);
    }
  }
}

// Directions so near to each other share their trials.
TEST_F(ContingencyTool, FewerTrialsWillDoWhereDirectionsAreDense) {
  const auto largest_confusion = [this](int directions) {
    const std::string file = Format("%d.bin", directions);
    ExpectRun(Format("measure hub --directions %d --shard 1/%d --threads 1 --output %s",
                     directions,
                     directions,
                     file.c_str()));
    const std::string text = Run("show " + file).text;
    const size_t line = text.find("largest_confusion");
    return line == std::string::npos ? text : text.substr(line, text.find('\n', line) - line);
  };
  EXPECT_NE(largest_confusion(391).find("0.08"), std::string::npos) << largest_confusion(391);
  EXPECT_NE(largest_confusion(6246).find("0.2"), std::string::npos) << largest_confusion(6246);
}

TEST_F(ContingencyTool, ShardsMergeToTheWholeAndShow) {
  ExpectRun(std::string(kFew) + "--rows 5 --threads 1 --output whole.bin");
  EXPECT_FALSE(fs::exists(scratch() / "whole.bin.trials"));
  for (const char* shard : {"1", "2"}) {
    ExpectRun(Format(
        "measure %s--rows 5 --threads 2 --shard %s/2 --output part%s.bin", kFew, shard, shard));
  }
  ExpectRefused("merge merged.bin part2.bin", "2 of 4 directions are in no part: 0, 2");
  ExpectRun("merge merged.bin part2.bin part1.bin");
  EXPECT_EQ(Bytes("merged.bin"), Bytes("whole.bin"));
  ExpectRun("merge --allow-incomplete partly.bin part2.bin");

  const ProgramOutput shown = Run("show whole.bin");
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_NE(shown.text.find("model        hub"), std::string::npos) << shown.text;
  EXPECT_NE(shown.text.find("directions   4 of 4 measured"), std::string::npos) << shown.text;
  EXPECT_NE(shown.text.find("rows         1 of 8480"), std::string::npos) << shown.text;
  const ProgramOutput csv = Run("show --csv part2.bin");
  EXPECT_EQ(std::count(csv.text.begin(), csv.text.end(), '\n'), 3) << csv.text;

  // Again, with other numbers, and with damage.
  ExpectRun(std::string(kFew) + "--rows 5 --output whole.bin");
  ExpectRefused(std::string(kFew) + "--seed 2 --output whole.bin", "its seed is \"1\"");
  ExpectRefused("mug --directions 4 --trials 3 --output whole.bin", "its model is \"hub\"");
  ExpectRefused(std::string(kFew) + "--estimator shot --output whole.bin", "estimator");
  ExpectRun("measure hub --directions 4 --trials 4 --output other.bin");
  ExpectRefused("merge merged.bin part1.bin other.bin", "other.bin is not of the same table");
  const std::string bytes = Bytes("whole.bin");
  std::ofstream(scratch() / "cut.bin") << bytes.substr(0, bytes.size() / 2);
  ExpectRefused("show cut.bin", "cut.bin");
  ExpectRefused("merge merged.bin part1.bin cut.bin", "cut.bin");
  std::string future = bytes;
  future[8] = 9;
  std::ofstream(scratch() / "future.bin") << future;
  ExpectRefused("show future.bin", "version 9");
}

TEST_F(ContingencyTool, TestsAndReports) {
  ExpectRun(std::string(kFew) + "--output t.bin");
  const ProgramOutput output = Run("test hub --table t.bin --directions 1 --rolls 1 --rows 0");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("Eq. 11: 200 trials a row"), std::string::npos) << output.text;
  EXPECT_EQ(Bytes("t.bin.report.txt"), output.text.substr(output.text.find("Left invariance")));
  EXPECT_TRUE(fs::exists(scratch() / "t.bin.report.json"));
  ExpectRefused("test mug --table t.bin", "its model is \"hub\"");
}

TEST_F(ContingencyTool, BadInputIsOneSentenceAndExitCodeTwo) {
  WriteSphere(scratch() / "ball.obj");
  ASSERT_EQ(
      RunProgram("vantage-model", "build ball.obj --unit mm --no-tables --output ball", scratch())
          .exit_code,
      0);
  std::ofstream(scratch() / "noise.bin") << "no table at all";
  ExpectRefused("measure", "model");
  ExpectRefused("none --output x.bin", "no model folder none");
  ExpectRefused("ball", "ball is a sphere");
  ExpectRefused("hub", "expected --output FILE");
  ExpectRefused("hub --output x.bin --shard 3/2", "--shard 3/2");
  ExpectRefused("hub --output x.bin --shard 1/0", "--shard 1/0");
  ExpectRefused("hub --output x.bin --k 0", "not in range 2 to 128");
  ExpectRefused("hub --output x.bin --trials 0", "not in range 1 to 1000000");
  ExpectRefused("hub --output x.bin --rows 5-2", "\"5-2\", expected numbers or ranges");
  ExpectRefused("hub --output /proc/x.bin", "/proc/x.bin.trials can't be opened");
  ExpectRefused("hub --output x.bin --estimator icp", "icp");
  ExpectRefused("hub --output x.bin --threads 0", "--threads");
  ExpectRefused("hub --output x.bin --rows 8480", "below 8480");
  ExpectRefused("hub --output x.bin --directions 1", "--directions 1");
  ExpectRefused("hub --output x.bin --directions 0", "expected something to measure");
  ExpectRefused("hub --output x.bin --config none.toml", "none.toml");
  ExpectRefused("hub --output none/x.bin", "none/x.bin.trials can't be opened");
  ExpectRefused("hub --output noise.bin", "not a contingency table");
  ExpectRefused("merge x.bin none.bin", "none.bin");
  ExpectRefused("show noise.bin", "not a contingency table");
  ExpectRefused("show none.bin", "none.bin: no such file");
  ExpectRefused("show ball", "ball is not a file");
  ExpectRefused("test hub", "expected --table FILE");
}

}  // namespace
}  // namespace vantage
