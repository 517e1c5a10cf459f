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
    if (!figure && figure.error().code == ErrorCode::kNotFound) GTEST_SKIP() << "gnuplot is not installed (Debian package gnuplot-nox)";
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
}

TEST_F(EvaluateReport, SentencesAreOfTheData) {
  EvaluationResults results = MadeUpResults(2).results();
  Write(results);
  const std::string before = Text("report.html");
  EXPECT_NE(before.find("Density mode is the best of our variants: median error 0.056° "
                        "[0.052, 0.060] modulo symmetry"),
            std::string::npos);
  EXPECT_NE(before.find("none is ahead of it in either"), std::string::npos);
  EXPECT_NE(before.find("the paper&#39;s at 3 of 3 k"), std::string::npos);
  results.accuracy[9].median_difference_deg = {-0.02, -0.03, -0.01};
  results.grids[1].num_cells = 68400;
  results.best_ours = "joint";
  Write(results);
  const std::string after = Text("report.html");
  EXPECT_NE(after.find("Joint refinement is the best of our variants: median error 0.070°"),
            std::string::npos);
  EXPECT_NE(after.find("ahead of it in one or both: Robust mean, Weiszfeld&#39;s algorithm."),
            std::string::npos);
  EXPECT_EQ(Count(before, ">● better<"), 0U);
  EXPECT_EQ(Count(after, ">● better<"), 1U);
  EXPECT_NE(after.find("the paper&#39;s at 2 of 3 k"), std::string::npos);
}

TEST_F(EvaluateReport, PaperStandsBesideOurs) {
  Write(MadeUpResults(3).results());
  const std::string page = Text("report.html");
  // Table 2 twice: filter, shampoo, pony, pitcher, rhino, spray, fish, dwarf.
  EXPECT_EQ(Count(page, "<tr class=\"paper\">"), 16U);
  EXPECT_NE(page.find("<tr class=\"paper\"><td>paper</td><td>88.57</td><td>81.03</td>"
                      "<td class=\"second\">0.617</td><td>178.7</td><td>178.7</td>"
                      "<td class=\"first\">0.423</td><td>175.7</td>"),
            std::string::npos);
  EXPECT_NE(page.find("<td>10.27</td><td class=\"soft\">10.28</td><td class=\"soft\">-0.01</td>"),
            std::string::npos);
}

TEST_F(EvaluateReport, HostileNamesAreEscaped) {
  EvaluationResults results = MadeUpResults(4).results();
  const std::string hostile = "</td><script>alert('1')</script>\"&`id` @x %s %d \\\n\x01\xff";
  results.methods[3].label = hostile;
  results.methods[7].label = hostile;  // The best of ours: in sentences and keys.
  results.methods[7].parameters = hostile;
  results.circle[4].model_id = hostile;
  results.circle[4].symmetry = "\"><script>";
  results.sequences[2].model_id = hostile;
  results.command = hostile;
  results.version = hostile;
  Write(results);
  const std::string page = Text("report.html");
  ExpectBalanced(page);
  EXPECT_EQ(Count(page, "<script"), 0U);
  EXPECT_NE(page.find("&lt;script&gt;"), std::string::npos);
  for (const char* name : {"forest", "boxes", "steps", "objects", "time"}) {
    const std::string figure = Text(fs::path("figures") / (std::string(name) + ".svg"));
    EXPECT_EQ(Count(figure, "<script"), 0U) << name;
    EXPECT_NE(figure.find("&lt;/td>&lt;script>alert("), std::string::npos) << name;
    EXPECT_EQ(Count(figure, "\xff"), 0U) << name;
  }
  EXPECT_NE(
      nlohmann::json::parse(Text("results.json"))["methods"][3]["label"].get<std::string>().find(
          "<script>alert('1')"),
      std::string::npos);
}

TEST_F(EvaluateReport, SectionsWithoutDataLeaveThePageSound) {
  EvaluationResults results = MadeUpResults(5).results();
  const auto figures = [&] { return Count(Text("report.html"), "<img "); };
  results.circle.clear();
  Write(results);
  ExpectBalanced(Text("report.html"));
  EXPECT_EQ(figures(), 4U);
  EXPECT_EQ(Count(Text("report.html"), "No views on the circle were computed."), 4U);
  results.sequences.clear();
  results.accuracy.clear();
  Write(results);
  ExpectBalanced(Text("report.html"));
  EXPECT_EQ(figures(), 2U);
  EXPECT_NE(Text("report.html").find("No sequences were run"), std::string::npos);
  Write({});
  ExpectBalanced(Text("report.html"));
  EXPECT_EQ(figures(), 0U);
  // Only the circle, of methods that the paper doesn't have, none of them ours.
  EvaluationResults circle = MadeUpResults(5).results();
  circle.sequences.clear();
  circle.accuracy.clear();
  circle.best_ours = "none";
  for (MethodInfo& method : circle.methods) method.id += "_other";
  Write(circle);
  ExpectBalanced(Text("report.html"));
}

TEST_F(EvaluateReport, NothingButNanStillMakesAPage) {
  EvaluationResults results = MadeUpResults(6).results();
  const auto clear = [](std::vector<double>* values) {
    std::fill(values->begin(), values->end(), kNone);
  };
  for (CircleErrors& object : results.circle) {
    clear(&object.detection_deg);
    clear(&object.detection_symmetric_deg);
    for (auto& steps : object.step_deg) clear(&steps);
    for (auto& steps : object.step_symmetric_deg) clear(&steps);
    for (auto& run : object.particle_runs_deg) clear(&run);
  }
  for (SequenceErrors& object : results.sequences) {
    object.detection_deg.clear();
    for (auto& finals : object.final_deg) clear(&finals);
  }
  for (auto& row : results.sweep.mean_error_deg) clear(&row);
  for (auto& row : results.sweep.wrong_mode_rate) clear(&row);
  for (MethodAccuracy& accuracy : results.accuracy) {
    accuracy = {};
    for (Interval* interval : {&accuracy.median_deg,
                               &accuracy.mean_deg,
                               &accuracy.wrong_mode_rate,
                               &accuracy.median_difference_deg,
                               &accuracy.difference_of_medians_deg,
                               &accuracy.difference_of_wrong_mode_rates}) {
      *interval = {kNone, kNone, kNone};
    }
    accuracy.seconds_per_view = kNone;
  }
  Write(results);
  const std::string page = Text("report.html");
  ExpectBalanced(page);
  EXPECT_EQ(Count(page, "nan"), 0U);
  EXPECT_EQ(Count(page, "inf"), 0U);
  const nlohmann::json json = nlohmann::json::parse(Text("results.json"));
  EXPECT_TRUE(json["accuracy"][0]["median_deg"]["value"].is_null());
  EXPECT_EQ(Count(Text("results.json"), "nan"), 0U);
}

TEST_F(EvaluateReport, ListsOfOtherLengthsAreRefusedByName) {
  const auto expect_refused = [&](const EvaluationResults& results, const std::string& part) {
    const Result<void> written = WriteEvaluation(results, folder());
    ASSERT_FALSE(written.ok()) << part;
    EXPECT_NE(written.error().message.find(part), std::string::npos) << written.error().message;
    EXPECT_FALSE(fs::exists(folder()));
  };
  EvaluationResults results = MadeUpResults(7).results();
  results.accuracy.pop_back();
  expect_refused(results, "accuracy has 13 entries, expected 14");
  results = MadeUpResults(7).results();
  results.circle[3].step_deg[2].pop_back();
  expect_refused(results, "a row of step_deg of duck has 29 entries, expected 30");
  results = MadeUpResults(7).results();
  results.sequences[3].final_deg.pop_back();
  expect_refused(results, "final_deg of duck has 13 entries, expected 14");
  results = MadeUpResults(7).results();
  results.sweep.w_min.push_back(1.0);
  expect_refused(results, "sweep.mean_error_deg has 9 entries, expected 10");
}

TEST_F(EvaluateReport, MissingGnuplotIsASentenceAndWritesNothing) {
  const char* path = std::getenv("PATH");
  const std::string before = path == nullptr ? "" : path;
  ::setenv("PATH", scratch().c_str(), 1);
  const Result<void> written = WriteEvaluation(MadeUpResults(8).results(), folder());
  ::setenv("PATH", before.c_str(), 1);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::kNotFound);
  EXPECT_NE(written.error().message.find("apt-get install gnuplot-nox"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder()));
}

TEST_F(EvaluateReport, FileThatCannotBeWrittenIsNamed) {
  EvaluationResults results;
  fs::create_directories(folder() / "report.html" / "in_the_way");
  const Result<void> written = WriteEvaluation(results, folder());
  ASSERT_FALSE(written.ok());
  EXPECT_NE(written.error().message.find((folder() / "report.html").string()), std::string::npos);
  EXPECT_FALSE(fs::exists(folder() / "report.html.part"));
  std::ofstream(scratch() / "file") << "x";
  const Result<void> no_folder = WriteEvaluation(results, scratch() / "file");
  ASSERT_FALSE(no_folder.ok());
  EXPECT_NE(no_folder.error().message.find((scratch() / "file").string()), std::string::npos);
}

}  // namespace
}  // namespace vantage
