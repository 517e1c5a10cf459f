#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace vantage {

struct ProgramOutput {
  int exit_code = -1;  ///< -1: it did not end by itself.
  std::string text;    ///< Standard output and error.
};

/// Runs a program of ours, which lies beside the test's own, in a folder.
inline ProgramOutput RunProgram(const std::string& name,
                                const std::string& arguments,
                                const std::filesystem::path& folder) {
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
  const std::string command =
      "cd '" + folder.string() + "' && '" + program.string() + "' " + arguments + " 2>&1";
  ProgramOutput output;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  std::array<char, 4096> buffer{};
  while (const size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    output.text.append(buffer.data(), got);
  }
  const int status = ::pclose(pipe);
  if (WIFEXITED(status)) output.exit_code = WEXITSTATUS(status);
  return output;
}

/// Paths of all files and folders below a folder, in order.
inline std::vector<std::string> ListTree(const std::filesystem::path& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// A test with a folder of its own, gone afterwards.
class ScratchTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "vantage-test.XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    scratch_ = name;
  }
  void TearDown() override {
    std::error_code ignored;
    if (!scratch_.empty()) std::filesystem::remove_all(scratch_, ignored);
  }
  [[nodiscard]] const std::filesystem::path& scratch() const { return scratch_; }

 private:
  std::filesystem::path scratch_;
};

/// A test of one program, run in the scratch folder.
class ToolTest : public ScratchTest {
 protected:
  explicit ToolTest(std::string program) : program_(std::move(program)) {}

  [[nodiscard]] ProgramOutput Run(const std::string& arguments) const {
    return RunProgram(program_, arguments, scratch());
  }
  /// Exit code 2, one sentence that has `part`, and nothing left behind.
  void ExpectRefused(const std::string& arguments, const std::string& part) const {
    SCOPED_TRACE(arguments);
    const auto before = ListTree(scratch());
    const ProgramOutput output = Run(arguments);
    EXPECT_EQ(output.exit_code, 2) << output.text;
    EXPECT_NE(output.text.find(part), std::string::npos) << output.text;
    EXPECT_EQ(output.text.find('\n'), output.text.size() - 1) << output.text;
    EXPECT_EQ(ListTree(scratch()), before);
  }

 private:
  std::string program_;
};

}  // namespace vantage
