// The output folder of an evaluation, from made-up results.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "perception/model/file_bytes.h"
#include "tests/tools/base64.h"
#include "tests/tools/made_up_results.h"
#include "tests/tools/run_program.h"
#include "tools/evaluate/report_writer.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

size_t Count(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

class EvaluateReport : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    const Result<std::string> figure = RunGnuplot("set terminal svg\nplot x\n");
    if (!figure && figure.error().code == ErrorCode::kNotFound) GTEST_SKIP() << "no gnuplot here";
  }
  [[nodiscard]] fs::path folder() const { return scratch() / "out" / "evaluate"; }
  [[nodiscard]] std::string Text(const fs::path& name) const {
    const Result<std::string> text = ReadFileBytes(folder() / name, size_t{1} << 27U);
    EXPECT_TRUE(text.ok()) << text.error().message;
    return text.ok() ? *text : "";
  }
  void Write(const EvaluationResults& results) {
    const Result<void> written = WriteEvaluation(results, folder());
    ASSERT_TRUE(written.ok()) << written.error().message;
  }
};

// Every element is closed, in order; the page's own void elements apart.
void ExpectBalanced(const std::string& html) {
  std::vector<std::string> open;
  for (size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const size_t end = html.find('>', at);
    ASSERT_NE(end, std::string::npos);
    std::string name = html.substr(at + 1, html.find_first_of(" >", at) - at - 1);
    if (name[0] == '!' || name == "meta" || name == "img") continue;
    if (name[0] != '/') {
      open.push_back(name);
      continue;
    }
    ASSERT_FALSE(open.empty()) << name;
    EXPECT_EQ("/" + open.back(), name) << html.substr(at > 200 ? at - 200 : 0, 260);
    open.pop_back();
  }
  EXPECT_TRUE(open.empty()) << open.back();
}

TEST_F(EvaluateReport, WritesPageFiguresAndTables) {
  const MadeUpResults made(1);
  Write(made.results());
  std::vector<std::string> expected;
  for (const char* name : {"",
                           "accuracy.csv",
                           "circle.csv",
                           "figures",
                           "figures/boxes.svg",
                           "figures/boxes_plain.svg",
                           "figures/forest.svg",
                           "figures/grid.svg",
                           "figures/objects.svg",
                           "figures/steps.svg",
                           "figures/sweep.svg",
                           "figures/time.svg",
                           "grid.csv",
                           "report.html",
                           "results.json",
                           "sequences.csv",
                           "sweep.csv"}) {
    if (*name != '\0') expected.push_back((folder() / name).string());
  }
  EXPECT_EQ(ListTree(folder()), expected);
  const std::string page = Text("report.html");
  ExpectBalanced(page);
  EXPECT_EQ(Count(page, "<img "), 8U);
  EXPECT_EQ(Count(page, "src=\"data:image/svg+xml;base64,"), 8U);
  EXPECT_EQ(Count(page, "src="), 8U) << "it needs no other file";
  EXPECT_EQ(Count(page, "http"), 0U);
  EXPECT_NE(page.find(made.results().command), std::string::npos);
  EXPECT_NE(page.find("18446744073709551557"), std::string::npos);
  EXPECT_NE(page.find("a final orientation 15° or more"), std::string::npos);
  EXPECT_NE(page.find("1080 sequences of 12 views over 18 objects"), std::string::npos);
  if (const char* keep = std::getenv("VANTAGE_KEEP_REPORT")) {
    fs::copy(folder(), keep, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
}

}  // namespace
}  // namespace vantage
