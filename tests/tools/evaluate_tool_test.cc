// Runs vantage-evaluate as its users do, on two models and few views.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string Text(const fs::path& file) {
  const Result<std::string> text = ReadFileBytes(file, size_t{1} << 27U);
  EXPECT_TRUE(text.ok()) << (text.ok() ? "" : text.error().message);
  return text.ok() ? *text : "";
}

// Without what differs from run to run.
Json WithoutTimes(Json json) {
  if (json.is_object()) {
    json.erase("seconds_per_view");
    json.erase("build_seconds");
  }
  if (json.is_structured()) {
    for (Json& part : json) part = WithoutTimes(std::move(part));
  }
  return json;
}

size_t CountRecords(const fs::path& folder) {
  size_t count = 0;
  if (!fs::is_directory(folder)) return 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string text = Text(entry.path());
    for (size_t at = text.find("\nend "); at != std::string::npos;
         at = text.find("\nend ", at + 1)) {
      ++count;
    }
  }
  return count;
}

class EvaluateTool : public ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    const Result<std::string> figure = RunGnuplot("set terminal svg\nplot x\n");
    if (!figure && figure.error().code == ErrorCode::kNotFound) GTEST_SKIP() << "gnuplot is not installed (Debian package gnuplot-nox)";
  }
  static std::string Few(const std::string& arguments) {
    return std::string("--models '") + VANTAGE_SOURCE_DIR +
           "/models' --use trefoil --use fish --views 2 --largest-grid 8 --output "
           "out " +
           arguments;
  }
  [[nodiscard]] ProgramOutput Run(const std::string& arguments) const {
    return RunProgram("vantage-evaluate", arguments, scratch());
  }
  // Exit code 2, one sentence that has `part`, and nothing done.
  void ExpectRefused(const std::string& arguments, const std::string& part) const {
    SCOPED_TRACE(arguments);
    const ProgramOutput output = Run(arguments);
    EXPECT_EQ(output.exit_code, 2);
    EXPECT_NE(output.text.find(part), std::string::npos) << output.text;
    EXPECT_EQ(std::count(output.text.begin(), output.text.end(), '\n'), 1) << output.text;
    EXPECT_EQ(output.text.rfind("vantage-evaluate: ", 0), 0U) << output.text;
  }
  [[nodiscard]] fs::path folder() const { return scratch() / "out" / "paper"; }
};

TEST_F(EvaluateTool, WritesAReportAndRepeatsItFromTheCache) {
  const ProgramOutput first = Run(Few("--paper --sequences 1 --threads 2"));
  ASSERT_EQ(first.exit_code, 0) << first.text;
  EXPECT_NE(first.text.find("64 views simulated, 0 from the cache"), std::string::npos)
      << first.text;
  for (const char* name : {"report.html",
                           "results.json",
                           "grid.csv",
                           "sweep.csv",
                           "circle.csv",
                           "sequences.csv",
                           "accuracy.csv"}) {
    EXPECT_GT(fs::file_size(folder() / name), 100U) << name;
  }
  const Json results = Json::parse(Text(folder() / "results.json"));
  ASSERT_EQ(results["sequences"].size(), 2U);
  EXPECT_EQ(results["sequences"][0]["num_views"], 2);
  EXPECT_EQ(results["circle"][1]["detection_deg"].size(), 30U);
  EXPECT_EQ(results["grids"].size(), 1U);
  EXPECT_EQ(results["best_blind"], "density_mode");
  EXPECT_EQ(results["accuracy"].size(), results["methods"].size());
  for (size_t i = 0; i < results["methods"].size(); ++i) {
    const bool is_blind = results["methods"][i]["id"] == results["best_blind"];
    const Json& difference = results["accuracy"][i]["difference_to_blind_deg"];
    EXPECT_TRUE(!is_blind || difference["value"] == 0.0) << difference;
  }

  const ProgramOutput second = Run(Few("--paper --sequences 1 --threads 1"));
  ASSERT_EQ(second.exit_code, 0) << second.text;
  EXPECT_NE(second.text.find("0 views simulated, 64 from the cache"), std::string::npos)
      << second.text;
  EXPECT_NE(second.text.find("12 outcomes of slow methods from the cache"), std::string::npos)
      << second.text;
  EXPECT_EQ(WithoutTimes(Json::parse(Text(folder() / "results.json"))), WithoutTimes(results));
}

TEST_F(EvaluateTool, AnInterruptedRunIsTakenUpAgain) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "vantage-evaluate";
  const std::string command = "cd '" + scratch().string() + "' && exec '" + program.string() +
                              "' " + Few("--paper --sequences 2000") + " > log 2>&1";
  std::vector<std::string> words = {"sh", "-c", command};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  ASSERT_EQ(::posix_spawn(&child, "/bin/sh", nullptr, nullptr, arguments.data(), environ), 0);
  // In the middle: something is kept and much is left to do.
  const fs::path cache = scratch() / "out" / "cache";
  int status = 0;
  while (CountRecords(cache) < 2 && ::waitpid(child, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_EQ(::kill(child, SIGINT), 0) << Text(scratch() / "log");
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << Text(scratch() / "log");
  EXPECT_EQ(WEXITSTATUS(status), 130) << Text(scratch() / "log");
  EXPECT_FALSE(fs::exists(folder() / "report.html"));
  const size_t num_kept = CountRecords(cache);
  EXPECT_GE(num_kept, 2U);

  const ProgramOutput later = Run(Few("--paper --sequences 1"));
  ASSERT_EQ(later.exit_code, 0) << later.text;
  EXPECT_TRUE(fs::exists(folder() / "report.html"));
  EXPECT_EQ(later.text.find(" 0 from the cache"), std::string::npos) << later.text;
}

TEST_F(EvaluateTool, TunesOnSequencesOfItsOwn) {
  const ProgramOutput output = Run(Few("--tune --sequences 1 --k 8"));
  ASSERT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("4 views simulated"), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("2 sequences of seed 1001"), std::string::npos) << output.text;
  const std::string csv = Text(scratch() / "out" / "tuning" / "tuning.csv");
  EXPECT_GT(std::count(csv.begin(), csv.end(), '\n'), 50) << csv;
  EXPECT_NE(csv.find("\nparticle_filter,"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder()));
}

TEST_F(EvaluateTool, RefusesBadArgumentsInOneSentence) {
  // Should one not be refused, there is little to do.
  const std::string models =
      std::string("--use trefoil --models '") + VANTAGE_SOURCE_DIR + "/models' ";
  ExpectRefused(models, "--paper");
  ExpectRefused(models + "--paper --tune", "--tune");
  ExpectRefused(models + "--paper --use unicorn", "unicorn");
  ExpectRefused("--paper --models nowhere", "nowhere");
  ExpectRefused(models + "--paper --k 0", "--k");
  ExpectRefused(models + "--paper --k 1000", "--k");
  ExpectRefused(models + "--paper --views 0", "--views");
  ExpectRefused(models + "--paper --sequences -2", "--sequences");
  ExpectRefused(models + "--paper --sequences many", "--sequences");
  ExpectRefused(models + "--paper --seed -1", "--seed");
  ExpectRefused(models + "--paper --threads 5000", "--threads");
  ExpectRefused(models + "--paper --no-such-option", "--no-such-option");
  for (const std::string& path : ListTree(scratch())) {
    EXPECT_FALSE(fs::is_regular_file(path)) << path;
  }
}

TEST_F(EvaluateTool, RefusesToTuneOnNothing) {
  const ProgramOutput output = Run(Few("--tune --sequences 0"));
  EXPECT_EQ(output.exit_code, 2);
  EXPECT_NE(output.text.find("--sequences = 0"), std::string::npos) << output.text;
}

TEST_F(EvaluateTool, RefusesAnOutputThatIsAFile) {
  std::ofstream(scratch() / "out") << "a file";
  ExpectRefused(Few("--paper --sequences 1"), "out/paper");
  ExpectRefused(Few("--tune --sequences 1"), "out/");
}

TEST_F(EvaluateTool, MissesGnuplotBeforeItBegins) {
  const std::string path = std::getenv("PATH");
  fs::create_directory(scratch() / "empty");
  ::setenv("PATH", (scratch() / "empty").c_str(), 1);
  ExpectRefused(Few("--paper --sequences 1"), "gnuplot");
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(fs::exists(scratch() / "out" / "cache"));
}

}  // namespace
}  // namespace vantage
