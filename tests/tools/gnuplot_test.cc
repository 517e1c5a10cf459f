#include "tools/support/gnuplot.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/format.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

class Gnuplot : public ScratchTest {
 protected:
  // A program that takes gnuplot's place.
  std::string Program(const std::string& body) {
    const fs::path file = scratch() / "plotter";
    std::ofstream(file) << "#!/bin/sh\n" << body << "\n";
    fs::permissions(file, fs::perms::owner_all);
    return file.string();
  }
};

TEST_F(Gnuplot, DrawsWithTheRealOne) {
  const Result<std::string> figure =
      RunGnuplot("set terminal svg\nset title 'eh'\nplot [0:1] x title 'identity'\n");
  if (!figure && figure.error().code == ErrorCode::kNotFound) GTEST_SKIP() << "gnuplot is not installed (Debian package gnuplot-nox)";
  ASSERT_TRUE(figure.ok()) << figure.error().message;
  EXPECT_NE(figure->find("<svg"), std::string::npos);
  EXPECT_NE(figure->find("identity"), std::string::npos);
  EXPECT_NE(figure->find("</svg>"), std::string::npos);
  const Result<std::string> refused = RunGnuplot("set terminal svg\nplot nonsense(\n");
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("gnuplot failed on a figure"), std::string::npos);
  EXPECT_NE(refused.error().message.find("nonsense"), std::string::npos) << "its own words";
}

TEST_F(Gnuplot, MissingProgramTellsHowToInstallIt) {
  const Result<std::string> figure = RunGnuplot("plot x\n", "no-such-plotter");
  ASSERT_FALSE(figure.ok());
  EXPECT_EQ(figure.error().code, ErrorCode::kNotFound);
  EXPECT_NE(figure.error().message.find("no-such-plotter"), std::string::npos);
  EXPECT_NE(figure.error().message.find("apt-get install gnuplot-nox"), std::string::npos);
}

TEST_F(Gnuplot, ProgramThatCannotRunIsAnError) {
  const Result<std::string> figure = RunGnuplot("plot x\n", scratch().string());
  ASSERT_FALSE(figure.ok());
  EXPECT_EQ(figure.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(figure.error().message.find("does not start"), std::string::npos);
}

TEST_F(Gnuplot, WholeScriptAndWholeFigurePassThrough) {
  // More than a pipe holds, both ways at once.
  std::string script;
  for (int i = 0; i < 40'000; ++i) script += Format("line %d\n", i);
  const Result<std::string> figure = RunGnuplot(script, Program("cat"));
  ASSERT_TRUE(figure.ok()) << figure.error().message;
  EXPECT_TRUE(*figure == script);
}

TEST_F(Gnuplot, NothingWrittenOrABadEndIsAnError) {
  EXPECT_FALSE(RunGnuplot("plot x\n", Program("exit 0")).ok());
  EXPECT_FALSE(RunGnuplot("plot x\n", Program("echo figure; exit 1")).ok());
  EXPECT_FALSE(RunGnuplot("plot x\n", Program("echo figure; kill -9 $$")).ok());
  const Result<std::string> loud =
      RunGnuplot("plot x\n", Program("yes complaint | head -c 100000 >&2; exit 3"));
  ASSERT_FALSE(loud.ok());
  EXPECT_NE(loud.error().message.find("complaint"), std::string::npos);
  EXPECT_LT(loud.error().message.size(), 1000U);
}

}  // namespace
}  // namespace vantage
